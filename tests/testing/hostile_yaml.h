#pragma once

#include <dn/error.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <array>
#include <string>
#include <vector>

namespace dn::testing {

/// Returns values that a key may have by mistake or malicious intent.
inline const std::vector<std::string>& HostileValues() {
  static const std::vector<std::string> values{"abc",
                                               "\"\"",
                                               "nan",
                                               ".nan",
                                               ".inf",
                                               "-.inf",
                                               "-inf",
                                               "0",
                                               "-1",
                                               "1e308",
                                               "-1e308",
                                               "1e-300",
                                               "1e9999",
                                               "1.5",
                                               "1e400000",
                                               "1000000000000",
                                               "true",
                                               "~",
                                               "[]",
                                               "[1]",
                                               "[1, 2, 3]",
                                               "[0, 0, 0]",
                                               "{}",
                                               "[.nan, .nan, .nan]",
                                               "{a: 1}",
                                               "[[1]]",
                                               "[{}, {}]",
                                               "[1e308, 1e308, 1e308]",
                                               "[1, 2, 3, 4, 5, 6, 7]",
                                               "[~]",
                                               "[[]]",
                                               "!!binary x",
                                               "\"a\\nb\"",
                                               std::string(3000, '1'),
                                               std::string(3000, 'x')};
  return values;
}

/// Calls visit(node) for every value of a document below its root, and for every map.
template <class Visit>
void VisitYaml(YAML::Node node, const Visit& visit) {
  if (node.IsMap()) {
    for (auto entry : node) {
      VisitYaml(entry.second, visit);
      visit(entry.second);
    }
  } else if (node.IsSequence()) {
    for (auto item : node) {
      VisitYaml(item, visit);
      visit(item);
    }
  }
}

/// Returns every document made from `text` by inserting one hostile value or one unknown key.
inline std::vector<std::string> HostileDocuments(const std::string& text) {
  std::vector<std::string> documents;
  std::size_t places = 0;
  VisitYaml(YAML::Load(text), [&](const YAML::Node&) { ++places; });
  for (std::size_t place = 0; place < places; ++place) {
    for (const std::string& value : HostileValues()) {
      YAML::Node root = YAML::Load(text);
      std::size_t at = 0;
      VisitYaml(root, [&](YAML::Node node) {
        if (at++ == place) node = YAML::Load(value);
      });
      documents.push_back(YAML::Dump(root));
    }
    YAML::Node root = YAML::Load(text);
    std::size_t at = 0;
    VisitYaml(root, [&](YAML::Node node) {
      if (at++ == place && node.IsMap()) node["unknown"] = 1;
    });
    documents.push_back(YAML::Dump(root));
  }
  return documents;
}

/// Runs `parse` on every hostile document of `text`. It must succeed or throw InvalidConfig with
/// file, line and column and a message that helps the user. Returns the number of rejected
/// documents.
template <class Parse>
int CountRefused(const std::string& text, const Parse& parse) {
  using ::testing::HasSubstr;
  using ::testing::Not;
  int refused = 0;
  for (const std::string& document : HostileDocuments(text)) {
    SCOPED_TRACE(document.substr(0, 2000));
    try {
      parse(document);
    } catch (const InvalidConfig& error) {
      ++refused;
      const std::string message = error.what();
      EXPECT_FALSE(error.where().file.empty()) << message;
      EXPECT_GT(error.where().line, 0) << message;
      EXPECT_GT(error.where().column, 0) << message;
      EXPECT_LT(message.size(), 1500u) << message;
      for (const char* part : {"covariance of dimension", "is not finite", "-nan",
                               "11111111111111111111111111111111111111111", "\n"}) {
        EXPECT_THAT(message, Not(HasSubstr(part)));
      }
    }
  }
  return refused;
}

}  // namespace dn::testing
