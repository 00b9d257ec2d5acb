#pragma once

#include <map>
#include <set>
#include <string>

namespace lsmvs {

// How scripts and ini files of another program say what our options say.
struct OptionSynonyms {
  // Its name of an option -> ours.
  std::map<std::string, std::string> names;
  // Keys without a section that its ini files hold for all of its commands: not an error in those
  // of our commands that lack them.
  std::set<std::string> common_keys;
  // Values that stand for "find it yourself", by its name of the option: as if it were not given.
  std::map<std::string, std::set<std::string>> default_texts;

  // Our name of an option.
  const std::string& Canonical(const std::string& name) const {
    const auto found = names.find(name);
    return found == names.end() ? name : found->second;
  }
  bool MeansDefault(const std::string& name, const std::string& text) const {
    const auto found = default_texts.find(name);
    return found != default_texts.end() && found->second.contains(text);
  }
};

}  // namespace lsmvs
