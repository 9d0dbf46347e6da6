#pragma once

#include <dn/error.h>
#include <dn/geo/little_endian.h>
#include <dn/geo/text_table.h>

#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "time_continuation.h"

namespace dn::geo_internal {

/// Format of a file of little-endian doubles, N per record; the first is the time.
template <std::size_t N>
struct RecordFormat {
  const char* name;  ///< name of the file format in messages
  std::array<const char*, N> columns;
};

template <std::size_t N>
using Record = std::array<double, N>;

inline std::string RecordName(std::size_t index) { return "record " + std::to_string(index + 1); }

/// Decodes all records. Throws InvalidInput if the last one is incomplete or a value is not finite.
template <std::size_t N>
std::vector<Record<N>> DecodeRecords(const std::string& content, const RecordFormat<N>& format,
                                     const FileLocation& where) {
  constexpr std::size_t kRecordBytes = 8 * N;
  const std::string name = format.name;
  if (content.empty()) throw InvalidInput(name + " file is empty", where);
  const std::size_t n = content.size() / kRecordBytes;
  if (content.size() % kRecordBytes != 0) {
    throw InvalidInput(name + " file is truncated: " + RecordName(n) + " has " +
                           std::to_string(content.size() % kRecordBytes) + " of " +
                           std::to_string(kRecordBytes) + " bytes",
                       where);
  }
  std::vector<Record<N>> records(n);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t c = 0; c < N; ++c) {
      const double value = LoadLittleEndian<double>(content.data() + i * kRecordBytes + 8 * c);
      if (!std::isfinite(value)) {
        throw InvalidInput(
            std::string(format.columns[c]) + " of " + name + " " + RecordName(i) + " is not finite",
            where);
      }
      records[i][c] = value;
    }
  }
  return records;
}

/// Removes repeated records and continues times over week rollovers; returns the number of removed
/// records.
template <std::size_t N>
long MakeTimesContinuous(const RecordFormat<N>& format, const FileLocation& where,
                         std::vector<Record<N>>* records) {
  using Verdict = TimeContinuation::Verdict;
  const std::string name = std::string(format.name) + " ";
  TimeContinuation times;
  std::vector<Record<N>>& kept = *records;  // the first n records; kept[n] is the one being judged
  const std::size_t all = records->size();
  std::size_t n = 0;
  for (std::size_t i = 0; i < all; ++i) {
    if (n != i) kept[n] = kept[i];
    try {
      CheckWeekSeconds(kept[n][0], where);
    } catch (const InvalidInput& e) {
      throw InvalidInput(name + RecordName(i) + ": " + e.what(), where);
    }
    const Verdict verdict = times.Next(kept[n].data(), N);
    if (verdict == Verdict::kNotIncreasing) {
      throw InvalidInput("time " + FormatDouble(kept[n][0]) + " s of " + name + RecordName(i) +
                             " does not increase: the record before has " +
                             FormatDouble(times.last_s() - times.offset_s()) + " s",
                         where);
    }
    if (verdict == Verdict::kKeep) ++n;
  }
  kept.resize(n);
  return static_cast<long>(all - n);
}

}  // namespace dn::geo_internal
