#include "usage_error.h"

#include <dn/names.h>

#include <algorithm>
#include <vector>

#include "command_names.h"
#include "shown_text.h"

namespace dn::apps {
namespace {

std::string Nearest(const std::string& word, const std::vector<std::string>& known) {
  return known.empty() ? std::string() : "; the nearest one is '" + NearestName(word, known) + "'";
}

std::string UnknownOption(const CLI::App& app, const std::string& word) {
  const std::string name = word.substr(0, word.find('='));
  return Quoted(name) + " is not an option" + Nearest(name, OptionNames(app));
}

std::string NoCommand(const CLI::App& program) {
  const std::vector<std::string> words = program.remaining();
  if (words.empty()) return "a command is required: " + JoinNames(CommandNames(program));
  const std::string& word = words.front();
  if (word.rfind("--", 0) == 0) return UnknownOption(program, word);
  return Quoted(word) + " is not a command" + Nearest(word, CommandNames(program));
}

std::string OptionIn(const std::string& text) {
  const std::size_t begin = std::min(text.find("--"), text.size());
  return text.substr(begin, text.find_first_of(" :=", begin) - begin);
}

std::string WhatIsWrong(const CLI::App& command, const CLI::ParseError& error) {
  std::string text = error.what();
  if (dynamic_cast<const CLI::ArgumentMismatch*>(&error) != nullptr) {
    return OptionIn(text) + " takes one value, given once";
  }
  if (dynamic_cast<const CLI::ConversionError*>(&error) != nullptr) {
    return OptionIn(text) + " takes no value";
  }
  const std::vector<std::string> words = command.remaining();
  if (dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr && !words.empty()) {
    const std::string& word = words.front();
    return word.rfind("--", 0) == 0 ? UnknownOption(command, word)
                                    : Quoted(word) + " is one argument too many";
  }
  return text;
}

}  // namespace

std::string UsageError(const CLI::App& program, const CLI::ParseError& error) {
  const std::vector<CLI::App*> given = program.get_subcommands();
  if (given.empty()) return "dn: error: " + NoCommand(program) + "; see dn --help";
  const CLI::App& command = *given.front();
  const std::string name = "dn " + command.get_name();
  return name + ": error: " + WhatIsWrong(command, error) + "; see " + name + " --help";
}

}  // namespace dn::apps
