#include "flight_copy.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>
#include <stdexcept>

namespace dn::testing {
namespace {

namespace fs = std::filesystem;

std::vector<double> NumbersOf(std::string line) {
  std::replace(line.begin(), line.end(), ',', ' ');
  std::istringstream stream(line);
  std::vector<double> numbers;
  for (double number = 0; stream >> number;) numbers.push_back(number);
  return numbers;
}

/// Where the line of `key` begins: in `section`, or at the top where the section is empty.
std::size_t FindKey(const std::string& yaml, const std::string& section, const std::string& key) {
  const std::string head = section.empty() ? "" : "\n" + section + ":\n";
  const std::size_t from = section.empty() ? 0 : yaml.find(head);
  const std::string line = section.empty() ? key + ":" : "\n  " + key + ":";
  const std::size_t at = from == std::string::npos ? from : yaml.find(line, from);
  if (at == std::string::npos) throw std::runtime_error("no key " + section + "." + key);
  return section.empty() ? at : at + 1;
}

}  // namespace

FlightCopy::FlightCopy(const fs::path& flight) {
  fs::create_directories(path() / "lidar");
  Take(flight, {"flight.yaml", "IMU.txt", "GPS.txt", "lidar"});
}

Table FlightCopy::Rows(const std::string& name) const {
  std::istringstream stream(ContentOf(path() / name));
  Table rows;
  for (std::string line; std::getline(stream, line);) {
    if (!line.empty() && line.front() != '#') rows.push_back(NumbersOf(std::move(line)));
  }
  return rows;
}

void FlightCopy::Write(const std::string& name, const Table& rows) const {
  std::string content;
  for (const std::vector<double>& row : rows) {
    content += fmt::format("{}\n", fmt::join(row, ","));
  }
  folder_.Write("flight/" + name, content);
}

void FlightCopy::EachRow(const std::string& name,
                         const std::function<void(std::vector<double>&)>& change) const {
  Table rows = Rows(name);
  for (std::vector<double>& row : rows) change(row);
  Write(name, rows);
}

std::vector<std::string> FlightCopy::PairFiles() const {
  std::vector<std::string> names = NamesIn(path() / "lidar");
  for (std::string& name : names) name.insert(0, "lidar/");
  return names;
}

void FlightCopy::EachPair(const std::function<void(std::vector<double>&)>& change) const {
  for (const std::string& name : PairFiles()) EachRow(name, change);
}

void FlightCopy::Set(const std::string& key, const std::string& value) const {
  std::string yaml = ContentOf(path() / "flight.yaml");
  const std::size_t dot = key.find('.');
  const std::string section = dot == std::string::npos ? "" : key.substr(0, dot);
  const std::size_t line =
      FindKey(yaml, section, dot == std::string::npos ? key : key.substr(dot + 1));
  const std::size_t begin = yaml.find(':', line) + 1;
  yaml.replace(begin, yaml.find('\n', begin) - begin, " " + value);
  folder_.Write("flight/flight.yaml", yaml);
}

void FlightCopy::Take(const fs::path& other, const std::vector<std::string>& names) const {
  for (const std::string& name : names) {
    fs::remove_all(path() / name);
    fs::copy(other / name, path() / name, fs::copy_options::recursive);
  }
}

ProgramRun FlightCopy::Calibrate() const {
  return RunProgram({"calibrate", path().string(), "--out", out().string()});
}

}  // namespace dn::testing
