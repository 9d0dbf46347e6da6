#include "gnss_meaning.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <initializer_list>
#include <string>
#include <string_view>

#include "lower_case.h"
#include "name_words.h"

namespace dn::files_internal {
namespace {

using NameWordList = std::vector<std::string>;
using WordChoice = std::initializer_list<std::string_view>;

bool IsAmong(std::string_view word, WordChoice list) {
  return std::find(list.begin(), list.end(), word) != list.end();
}

bool HasWord(const NameWordList& words, WordChoice list) {
  return std::any_of(words.begin(), words.end(),
                     [&](const std::string& word) { return IsAmong(word, list); });
}

bool IsDigit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

/// Separates words that begin with a capital letter: "GPSTime" becomes "GPS Time".
std::string WithoutCamelCase(std::string_view name) {
  std::string spelled;
  for (std::size_t i = 0; i < name.size(); ++i) {
    const bool after_lower = i > 0 && (IsLower(name[i - 1]) || IsDigit(name[i - 1]));
    const bool before_lower =
        i > 0 && IsUpper(name[i - 1]) && i + 1 < name.size() && IsLower(name[i + 1]);
    if (IsUpper(name[i]) && (after_lower || before_lower)) spelled += ' ';
    spelled += name[i];
  }
  return spelled;
}

/// Returns the unit that a word names; empty if it names none.
std::string_view WordUnit(std::string_view word) {
  if (IsAmong(word, {"deg", "degree", "degrees"})) return "deg";
  if (IsAmong(word, {"rad", "radian", "radians"})) return "rad";
  if (IsAmong(word, {"m", "meter", "meters", "metre", "metres"})) return "m";
  if (IsAmong(word, {"ft", "feet", "foot"})) return "ft";
  if (IsAmong(word, {"e7", "1e7", "dege7"})) return "1e7";
  if (IsAmong(word, {"mps"})) return "m/s";
  return IsAmong(word, {"mm", "cm", "km", "ddmm", "usft"}) ? word : std::string_view();
}

/// Separates words that are written together: "latdeg", "gpslat".
NameWordList WithGluedWordsApart(const NameWordList& words) {
  NameWordList apart;
  for (const std::string& word : words) {
    std::size_t begin = 0;
    for (const std::string_view receiver : {"gps", "gnss"}) {
      const bool glued = word.starts_with(receiver) &&
                         !FindMeaning(word.substr(receiver.size())).name.empty() &&
                         FindMeaning(word).name.empty();
      if (glued) begin = receiver.size();
    }
    std::string rest = word.substr(begin);
    if (begin > 0) apart.push_back(word.substr(0, begin));
    for (const std::string_view angle : {"latitude", "longitude", "lat", "lon"}) {
      if (!rest.starts_with(angle) || WordUnit(rest.substr(angle.size())).empty()) continue;
      apart.emplace_back(angle);
      rest = rest.substr(angle.size());
      break;
    }
    apart.push_back(rest);
  }
  return apart;
}

std::string Joined(const NameWordList& words) {
  std::string name;
  for (const std::string& word : words) name += (name.empty() ? "" : " ") + word;
  return name;
}

/// Moves a unit at the end of the words into brackets. `bracket`: the unit that the name has there.
std::string Spelled(NameWordList words, const std::string& bracket) {
  std::string unit = bracket;
  const std::size_t count = words.size();
  if (unit.empty() && count > 2 && words[count - 2] == "m" && words[count - 1] == "s") {
    words.resize(count - 2);
    unit = "(m/s)";
  } else if (unit.empty() && count > 1 && !WordUnit(words.back()).empty()) {
    unit = "(" + std::string(WordUnit(words.back())) + ")";
    words.pop_back();
    if (unit == "(1e7)" && words.size() > 1 && words.back() == "deg") words.pop_back();
  }
  return unit.empty() ? Joined(words) : Joined(words) + " " + unit;
}

/// Returns the number of an element of a covariance, as in "covariance[4]"; -1 without one.
int CovarianceElement(const std::string& name) {
  const std::size_t at = name.find("covariance");
  if (at == name.npos) return -1;
  std::string digits;
  for (const char c : name.substr(at)) {
    if (IsDigit(c)) digits += c;
  }
  return digits.empty() || digits.size() > 2 ? -1 : std::stoi(digits);
}

std::string CovarianceName(const std::string& name) {
  for (const char* other : {"vel", "orientation", "angular", "twist", "acceleration"}) {
    if (name.find(other) != name.npos) return {};
  }
  switch (CovarianceElement(name)) {  // a matrix of east, north, up in rows
    case 0:
      return "var_e";
    case 4:
      return "var_n";
    case 8:
      return "var_u";
    default:
      return {};
  }
}

/// Returns var_e, var_n or var_u for the variance of a position.
std::string VarianceName(NameWordList words) {
  for (std::string& word : words) {
    if (IsAmong(word, {"var", "variance"})) word = "sd";
    if (word.size() == 4 && word.starts_with("var")) word = "sd" + word.substr(3);
  }
  const std::string sigma = FindMeaning(Joined(words)).name;
  if (sigma == "sigma_e" || sigma == "sigma_n" || sigma == "sigma_u") {
    return "var_" + sigma.substr(6);
  }
  return sigma == "sigma_d" ? "var_u" : "";
}

bool IsVariance(const NameWordList& words) {
  return HasWord(words, {"var", "variance", "vare", "varn", "varu", "vard"});
}

/// Returns the quantity of an accuracy that is not that of one axis; empty for other columns.
std::string AccuracyName(const NameWordList& words) {
  if (HasWord(words, {"vel", "velocity", "speed", "heading", "course", "bearing", "yaw", "roll",
                      "pitch", "time", "cog", "dop", "pdop", "hdop", "vdop", "x", "y", "z"})) {
    return {};
  }
  if (HasWord(words, {"eph", "hacc"})) return "sigma_en";
  if (HasWord(words, {"epv", "vacc"})) return "sigma_u";
  const bool deviation = HasWord(words, {"sd", "std", "stdev", "stddev", "sigma", "rms"});
  if (!deviation && !HasWord(words, {"accuracy", "acc", "uncertainty", "error", "err"})) return {};
  if (HasWord(words, {"horizontal", "horiz", "hor", "2d"})) return "sigma_en";
  if (HasWord(words, {"vertical", "vert"})) return "sigma_u";
  const bool short_name = words.size() == 2 && words[1] == "acc";
  if (short_name && words[0] == "h") return "sigma_en";
  if (short_name && words[0] == "v") return "sigma_u";
  return {};
}

std::string HemisphereName(const NameWordList& words, const std::string& text) {
  if (text.size() != 1) return {};
  const char letter = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  const bool hemisphere = HasWord(words, {"hemisphere", "hemi", "dir", "direction", "indicator",
                                          "ref", "ns", "ew", "n", "s", "e", "w"});
  if (!hemisphere) return {};
  if (letter == 'N' || letter == 'S') return "lat_ns";
  return letter == 'E' || letter == 'W' ? "lon_ew" : "";
}

ColumnMeaning FindGnssMeaning(const std::string& name, const std::string& text) {
  const std::string lower = LowerCase(name);
  ColumnMeaning meaning = FindMeaning(name);
  const NameWordList words = SplitWords(lower.substr(0, lower.find_first_of("([{")));
  if (const std::string hemisphere = HemisphereName(words, text); !hemisphere.empty()) {
    return {hemisphere, ""};
  }
  if (lower.find("covariance") != lower.npos) return {CovarianceName(lower), ""};
  if (IsVariance(words)) return {VarianceName(words), ""};
  if (const std::string accuracy = AccuracyName(words); !accuracy.empty()) {
    meaning.name = accuracy;
  } else if (meaning.name.empty() && HasWord(words, {"accuracy", "uncertainty", "sd3d", "acc3d"}) &&
             !HasWord(words, {"speed", "velocity", "heading", "bearing", "course", "time"})) {
    meaning.name = "accuracy";
  } else if (meaning.name.empty() && words.size() <= 2 &&
             HasWord(words, {"ele", "elevation", "hae"}) &&
             !HasWord(words, {"ground", "terrain", "surface", "mask", "angle", "sun"})) {
    meaning.name = "h";
  } else if (HasWord(words, {"dop", "hdop", "vdop", "pdop", "geoidal"})) {
    meaning.name.clear();
  }
  return meaning;
}

/// Names the columns by symbols of geodesy, which are known only together: phi, lambda or B, L, H.
void TakeSymbols(const TextSample& spelled, std::vector<ColumnMeaning>* meanings) {
  struct Symbols {
    std::string_view lat, lon, h;
  };
  for (const Symbols& symbols : {Symbols{"phi", "lambda", ""}, Symbols{"b", "l", "h"}}) {
    std::array<std::size_t, 3> at{};
    std::array<bool, 3> found{};
    for (std::size_t i = 0; i < spelled.names.size(); ++i) {
      const NameWordList words = SplitWords(LowerCase(spelled.names[i]));
      if (words.empty()) continue;
      for (std::size_t k = 0; k < 3; ++k) {
        const std::string_view symbol = k == 0 ? symbols.lat : k == 1 ? symbols.lon : symbols.h;
        if (found[k] || words[0] != symbol) continue;
        found[k] = true;
        at[k] = i;
      }
    }
    if (!found[0] || !found[1] || (!symbols.h.empty() && !found[2])) continue;
    (*meanings)[at[0]].name = "lat";
    (*meanings)[at[1]].name = "lon";
    if (found[2]) (*meanings)[at[2]].name = "h";
  }
}

}  // namespace

std::string SpelledName(const std::string& name) {
  if (LowerCase(name).find("covariance") != std::string::npos) return name;
  const std::size_t open = std::min(name.find_first_of("([{"), name.size());
  return Spelled(WithGluedWordsApart(SplitWords(LowerCase(WithoutCamelCase(name.substr(0, open))))),
                 name.substr(open));
}

TextSample WithSpelledNames(const TextSample& sample) {
  TextSample spelled = sample;
  for (std::string& name : spelled.names) name = SpelledName(name);
  return spelled;
}

std::vector<ColumnMeaning> FindGnssMeanings(const TextSample& spelled) {
  std::vector<ColumnMeaning> meanings;
  for (std::size_t i = 0; i < spelled.names.size(); ++i) {
    const std::string text = i < spelled.first_row.size() ? spelled.first_row[i] : std::string();
    meanings.push_back(FindGnssMeaning(spelled.names[i], text));
  }
  TakeSymbols(spelled, &meanings);
  return meanings;
}

}  // namespace dn::files_internal
