#pragma once

#include <dn/blind_check/blind_record.h>
#include <dn/names.h>
#include <dn/report/json_reader.h>

#include <optional>
#include <string>
#include <vector>

namespace dn {

inline std::optional<double> OptionalNumber(const JsonPlace& json) {
  return json.is_null() ? std::nullopt : std::optional(json.Number());
}

/// Returns a name that is safe in tables and in lists separated by commas.
inline std::string WordFromJson(const JsonPlace& json) {
  constexpr std::size_t kLongest = 200;
  std::string word = json.Text(kLongest);
  if (HasControls(word) || word.find_first_of(",\"") != std::string::npos)
    json.Fail("must not contain commas, quotes or control characters");
  return word;
}

inline std::vector<std::string> WordsFromJson(const JsonPlace& json) {
  std::vector<std::string> words;
  for (const JsonPlace& word : json.Elements()) words.push_back(WordFromJson(word));
  return words;
}

/// Returns the numbers of a list; null represents an empty list.
inline std::vector<double> NumbersFromJson(const JsonPlace& json) {
  std::vector<double> numbers;
  if (json.is_null()) return numbers;
  for (const JsonPlace& number : json.Elements()) numbers.push_back(ReadNumberOrNaN(number));
  return numbers;
}

/// Returns the causes of gap.json or of a record, which have the same format.
inline std::vector<BlindCause> CausesFromJson(const JsonPlace& json) {
  std::vector<BlindCause> causes;
  for (const JsonPlace& cause : json.Elements()) {
    causes.push_back({WordFromJson(cause.At("effect")), ReadNumberOrNaN(cause.At("posterior")),
                      NumbersFromJson(cause.At("estimate")), NumbersFromJson(cause.At("sigma"))});
  }
  return causes;
}

}  // namespace dn
