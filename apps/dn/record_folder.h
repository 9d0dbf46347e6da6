#pragma once

#include <dn/error.h>
#include <dn/report/json_reader.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "json_file.h"

namespace dn::apps {

/// Reads the record of the flight or design `number`. Throws InvalidInput if the value is not a
/// record or belongs to another number.
template <class Record>
using RecordReader = std::function<Record(const JsonPlace& json, std::uint64_t number)>;

/// Folder with one numbered record file per finished flight. With it an interrupted run can be
/// resumed and shards can be merged. Each record has the hash of what it was made from.
class RecordFolder {
 public:
  /// Opens or creates the folder. Throws InvalidConfig if it has records of a series that was not
  /// made from `made_from`, and UnusableOutput if it is a link or a file.
  RecordFolder(std::filesystem::path folder, const Json& made_from);

  /// Reads a record; nullopt if the file does not exist. Throws like ReadFile.
  template <class Record>
  std::optional<Record> Read(std::uint64_t number, const RecordReader<Record>& reader) const {
    const std::filesystem::path file = RecordFile(folder_, number);
    if (!IsThere(file)) return std::nullopt;
    return ReadFile(file, number, hash_, reader);
  }

  void Write(std::uint64_t number, Json record) const;

  /// Reads a record file that must exist. Throws InvalidInput if it is not a regular file or not a
  /// record, if it has another number, or if it was not made from the content with this `hash`.
  template <class Record>
  static Record ReadFile(const std::filesystem::path& file, std::uint64_t number,
                         const std::string& hash, const RecordReader<Record>& reader) {
    try {
      const Json json = ReadJsonFile(file);
      const JsonPlace place(json, file.string());
      ExpectHash(place, hash);
      return reader(place, number);
    } catch (const InvalidInput& error) {
      Refuse(error);
    }
  }

  static std::filesystem::path RecordFile(const std::filesystem::path& folder,
                                          std::uint64_t number);
  static bool IsThere(const std::filesystem::path& file);

  static std::filesystem::path MadeFromFile(const std::filesystem::path& folder);
  /// Reads from which scenario and options the records of a folder were made. Throws InvalidInput
  /// if the folder does not state it.
  static Json MadeFrom(const std::filesystem::path& folder);
  /// The hash in the records made from it.
  static std::string MadeFromHash(const Json& made_from);

 private:
  [[noreturn]] static void Refuse(const InvalidInput& error);
  static void ExpectHash(const JsonPlace& record, const std::string& hash);
  void RemoveUnfinished() const;

  std::filesystem::path folder_;
  std::string hash_;
};

}  // namespace dn::apps
