#pragma once

#include <dn/error.h>
#include <dn/report/json.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace dn::apps {

/// Folder with one numbered record file per finished flight. With it an interrupted run can be
/// resumed and shards can be merged.
class RecordFolder {
 public:
  /// Opens or creates the folder. Throws InvalidConfig if it has records of a series that was not
  /// made from `made_from`.
  RecordFolder(std::filesystem::path folder, const Json& made_from);

  /// Reads and parses a record; nullopt if the file does not exist. Throws InvalidInput if the file
  /// is not a valid record.
  template <class Parse>
  auto Read(std::uint64_t number, const Parse& parse) const
      -> std::optional<decltype(parse(Json()))> {
    const std::filesystem::path file = FileOf(folder_, number);
    if (!std::filesystem::exists(file)) return std::nullopt;
    return ReadFile(file, parse);
  }

  void Write(std::uint64_t number, const Json& record) const;

  /// Reads and parses a record file that must exist.
  template <class Parse>
  static auto ReadFile(const std::filesystem::path& file, const Parse& parse)
      -> decltype(parse(Json())) {
    try {
      return parse(ParseFile(file));
    } catch (const Json::exception& error) {
      throw InvalidInput(std::string("not the record of a flight (") + error.what() +
                             "); delete the file to fly it again",
                         {file.string()});
    }
  }

  static std::filesystem::path FileOf(const std::filesystem::path& folder, std::uint64_t number);

  /// Reads from which scenario and options the records of a folder were made. Throws InvalidInput
  /// if the folder does not state it.
  static Json MadeFrom(const std::filesystem::path& folder);

 private:
  static Json ParseFile(const std::filesystem::path& file);
  void RemoveUnfinished() const;

  std::filesystem::path folder_;
};

}  // namespace dn::apps
