#pragma once

#include <utility>

#include "lsmvs/program/command.h"

namespace lsmvs {

// A command that describes an options struct and hands it to one function. `Options` has
// Describe(OptionSet*), and ApplyPresets() if it has presets (see Command).
template <class Options>
class OptionsCommand : public Command {
 public:
  using Work = void (*)(const Options& options, const CommandContext& context);

  OptionsCommand(CommandInfo info, Work work) : info_(std::move(info)), work_(work) {}

  CommandInfo Info() const override { return info_; }
  void Describe(OptionSet* options) override { options_.Describe(options); }
  void ApplyPresets() override {
    if constexpr (requires { options_.ApplyPresets(); }) options_.ApplyPresets();
  }
  void Run(const CommandContext& context) override { work_(options_, context); }

 private:
  CommandInfo info_;
  Work work_;
  Options options_;
};

template <class Options>
std::unique_ptr<Command> MakeOptionsCommand(CommandInfo info,
                                            void (*work)(const Options& options,
                                                         const CommandContext& context)) {
  return std::make_unique<OptionsCommand<Options>>(std::move(info), work);
}

}  // namespace lsmvs
