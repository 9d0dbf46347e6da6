#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>
#include <string>

#include "command.h"
#include "command_names.h"

namespace dn::apps {
namespace {

/// Returns a bash function that completes commands and options. For all other words bash completes
/// file names.
std::string BashScript(const CLI::App& program) {
  std::string cases;
  for (const CLI::App* command : program.get_subcommands([](const CLI::App*) { return true; })) {
    cases += fmt::format("    {}) words=\"{}\" ;;\n", command->get_name(),
                         fmt::join(OptionNames(*command), " "));
  }
  return fmt::format(
      "_dn() {{\n"
      "  local word=\"${{COMP_WORDS[COMP_CWORD]}}\" words=\"\"\n"
      "  COMPREPLY=()\n"
      "  if [ \"$COMP_CWORD\" -eq 1 ]; then\n"
      "    words=\"{} {}\"\n"
      "  else case \"${{COMP_WORDS[1]}}\" in\n"
      "{}"
      "  esac; case \"$word\" in -*) ;; *) return ;; esac; fi\n"
      "  COMPREPLY=($(compgen -W \"$words\" -- \"$word\"))\n"
      "}}\n"
      "complete -o default -F _dn dn\n",
      fmt::join(CommandNames(program), " "), fmt::join(OptionNames(program), " "), cases);
}

}  // namespace

void AddCompletion(CLI::App* program, Action* action) {
  auto shell = std::make_shared<std::string>();
  CLI::App* app =
      program->add_subcommand("completion", "Prints a script for shell completion of dn commands");
  app->set_version_flag("--version", "dn " DN_VERSION);
  app->add_option("SHELL", *shell, "Shell of the script: bash or zsh")
      ->required()
      ->check(CLI::IsMember({"bash", "zsh"}));
  app->footer("Example: source <(dn completion bash)");
  app->callback([program, shell, action] {
    *action = [program, shell] {
      if (*shell == "zsh") fmt::print("autoload -U +X bashcompinit && bashcompinit\n");
      fmt::print("{}", BashScript(*program));
      return FlushStandardOutput("completion") ? 0 : 1;
    };
  });
}

}  // namespace dn::apps
