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

/// Reads the record of a flight or design of this number. Throws InvalidInput for what is no record,
/// or that of something else.
template <class Record>
using RecordReader = std::function<Record(const JsonPlace& json, std::uint64_t number)>;

/// The records of finished flights, one file each by number, so that an interrupted run can be
/// taken up, and shards be joined. Each holds the hash of what it was made from.
class RecordFolder {
 public:
  /// Throws InvalidConfig when the folder holds the records of something else than `made_from`, and
  /// UnusableOutput when it is a link or a file.
  RecordFolder(std::filesystem::path folder, const Json& made_from);

  /// The record of a number; nothing where there is none. Throws as ReadFile.
  template <class Record>
  std::optional<Record> Read(std::uint64_t number, const RecordReader<Record>& reader) const {
    const std::filesystem::path file = FileOf(folder_, number);
    if (!IsThere(file)) return std::nullopt;
    return ReadFile(file, number, hash_, reader);
  }

  void Write(std::uint64_t number, Json record) const;

  /// A record that must be there. Throws InvalidInput for what is no regular file, no record, one of
  /// another number, and one that was not made from what has this `hash`.
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

  static std::filesystem::path FileOf(const std::filesystem::path& folder, std::uint64_t number);
  static bool IsThere(const std::filesystem::path& file);

  static std::filesystem::path MadeFromFile(const std::filesystem::path& folder);
  /// What the records of a folder were made from. Throws InvalidInput where it does not say.
  static Json MadeFrom(const std::filesystem::path& folder);
  /// The hash that the records made from it hold.
  static std::string HashOf(const Json& made_from);

 private:
  [[noreturn]] static void Refuse(const InvalidInput& error);
  static void ExpectHash(const JsonPlace& record, const std::string& hash);
  void RemoveUnfinished() const;

  std::filesystem::path folder_;
  std::string hash_;
};

}  // namespace dn::apps
