#pragma once

#include <dn/error.h>
#include <dn/report/json.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace dn::apps {

/// The records of finished flights, one file each by number, so that an interrupted run can be
/// taken up, and shards be joined.
class RecordFolder {
 public:
  /// Throws InvalidConfig when the folder holds the records of something else than `made_from`.
  RecordFolder(std::filesystem::path folder, const Json& made_from);

  /// What `parse` makes of a record; nothing where there is none. Throws InvalidInput for what is no
  /// record.
  template <class Parse>
  auto Read(std::uint64_t number, const Parse& parse) const
      -> std::optional<decltype(parse(Json()))> {
    const std::filesystem::path file = FileOf(folder_, number);
    if (!std::filesystem::exists(file)) return std::nullopt;
    return ReadFile(file, parse);
  }

  void Write(std::uint64_t number, const Json& record) const;

  /// As Read, of a record that must be there.
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

  /// What the records of a folder were made from. Throws InvalidInput where it does not say.
  static Json MadeFrom(const std::filesystem::path& folder);

 private:
  static Json ParseFile(const std::filesystem::path& file);
  void RemoveUnfinished() const;

  std::filesystem::path folder_;
};

}  // namespace dn::apps
