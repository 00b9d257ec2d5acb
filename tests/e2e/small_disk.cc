#include "small_disk.h"

#include <sys/mount.h>

#include <cerrno>
#include <cstring>

namespace lsmvs {

SmallDisk::SmallDisk(const std::string& size) {
  mounted_ = ::mount("tmpfs", folder_.path().c_str(), "tmpfs", 0, ("size=" + size).c_str()) == 0;
  if (!mounted_) reason_ = std::strerror(errno);
}

SmallDisk::~SmallDisk() {
  if (mounted_) ::umount2(folder_.path().c_str(), MNT_DETACH);
}

void SmallDisk::MakeReadOnly() const {
  ::mount("tmpfs", folder_.path().c_str(), "tmpfs", MS_REMOUNT | MS_RDONLY, nullptr);
}

}  // namespace lsmvs
