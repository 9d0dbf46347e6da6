#include "flight_of_numbers.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>
#include <stdexcept>

namespace dn::testing {
namespace {

namespace fs = std::filesystem;

std::vector<double> SplitNumbers(std::string line) {
  std::replace(line.begin(), line.end(), ',', ' ');
  std::istringstream stream(line);
  std::vector<double> numbers;
  for (double number = 0; stream >> number;) numbers.push_back(number);
  return numbers;
}

/// Returns the position at which the line of a key begins. A key of a section is SECTION.KEY.
std::size_t FindKey(const std::string& yaml, const std::string& key) {
  const std::size_t dot = key.find('.');
  const bool top = dot == std::string::npos;
  const std::size_t section = top ? 0 : yaml.find("\n" + key.substr(0, dot) + ":\n");
  const std::string line = top ? "\n" + key + ":" : "\n  " + key.substr(dot + 1) + ":";
  const std::size_t at = yaml.find(line, section);
  if (at == std::string::npos) throw std::runtime_error("flight.yaml has no key " + key);
  return at + 1;
}

}  // namespace

Table FlightOfNumbers::Rows(const std::string& name) const {
  std::istringstream stream(Read(name));
  Table rows;
  for (std::string line; std::getline(stream, line);) {
    if (!line.empty() && line.front() != '#') rows.push_back(SplitNumbers(std::move(line)));
  }
  return rows;
}

void FlightOfNumbers::WriteRows(const std::string& name, const Table& rows) const {
  std::string content;
  for (const std::vector<double>& row : rows) {
    content += fmt::format("{}\n", fmt::join(row, ","));
  }
  Write(name, content);
}

void FlightOfNumbers::EachRow(const std::string& name,
                              const std::function<void(std::vector<double>&)>& change) const {
  Table rows = Rows(name);
  for (std::vector<double>& row : rows) change(row);
  WriteRows(name, rows);
}

std::vector<std::string> FlightOfNumbers::PairFiles() const {
  std::vector<std::string> names = NamesIn(path() / "lidar");
  for (std::string& name : names) name.insert(0, "lidar/");
  return names;
}

void FlightOfNumbers::EachPair(const std::function<void(std::vector<double>&)>& change) const {
  for (const std::string& name : PairFiles()) EachRow(name, change);
}

void FlightOfNumbers::Set(const std::string& key, const std::string& value) const {
  std::string yaml = Read("flight.yaml");
  const std::size_t begin = yaml.find(':', FindKey(yaml, key)) + 1;
  yaml.replace(begin, yaml.find('\n', begin) - begin, " " + value);
  Write("flight.yaml", yaml);
}

void FlightOfNumbers::Take(const fs::path& other, const std::vector<std::string>& names) const {
  for (const std::string& name : names) {
    fs::remove_all(path() / name);
    fs::copy(other / name, path() / name, fs::copy_options::recursive);
  }
}

}  // namespace dn::testing
