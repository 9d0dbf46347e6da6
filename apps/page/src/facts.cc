#include "facts.h"

#include <dn/error.h>
#include <dn/report/json_reader.h>

#include <cmath>
#include <limits>
#include <utility>

namespace dn::page_internal {
namespace {

constexpr std::size_t kMostTexts = 10'000;

}  // namespace

Facts::Facts(std::string file, Json json, RowsLeft rows_left)
    : source_(std::move(file) + "#"),
      root_(std::make_shared<const Json>(std::move(json))),
      rows_left_(std::move(rows_left)) {
  json_ = root_.get();
}

Facts Facts::At(const Json* json, const std::string& key) const {
  Facts place;
  place.source_ = source_ + "/" + EscapedKey(key);
  place.root_ = root_;
  place.rows_left_ = rows_left_;
  place.json_ = json;
  return place;
}

Facts Facts::operator[](const std::string& key) const {
  const bool there = json_ != nullptr && json_->is_object() && json_->contains(key);
  return At(there ? &json_->at(key) : nullptr, key);
}

Facts Facts::operator[](std::size_t index) const {
  const bool there = json_ != nullptr && json_->is_array() && index < json_->size();
  return At(there ? &json_->at(index) : nullptr, std::to_string(index));
}

void Facts::Take(std::size_t rows) const {
  if (rows > *rows_left_) {
    throw InvalidInput(source_ + ": this folder has more rows than a page can show");
  }
  *rows_left_ -= rows;
}

std::vector<Facts> Facts::elements() const {
  std::vector<Facts> list;
  if (json_ == nullptr || !json_->is_structured()) return list;
  Take(json_->size());
  std::size_t index = 0;
  for (const auto& item : json_->items()) {
    list.push_back(At(&item.value(), json_->is_object() ? item.key() : std::to_string(index)));
    ++index;
  }
  return list;
}

std::vector<std::string> Facts::keys() const {
  std::vector<std::string> names;
  if (json_ == nullptr || !json_->is_object()) return names;
  Take(json_->size());
  for (const auto& item : json_->items()) names.push_back(item.key());
  return names;
}

Curve Facts::points(const std::string& label) const {
  Curve curve{label, {}, {}};
  for (std::size_t k = 0; json_ != nullptr && json_->is_array() && k < json_->size(); ++k) {
    const Facts point = (*this)[k];
    curve.x.push_back(point[0].number());
    curve.y.push_back(point[1].number());
  }
  return curve;
}

double Facts::number() const {
  const bool there = json_ != nullptr && json_->is_number();
  return there ? json_->get<double>() : std::numeric_limits<double>::quiet_NaN();
}

bool Facts::flag() const { return json_ != nullptr && json_->is_boolean() && json_->get<bool>(); }

std::string Facts::text() const {
  return json_ != nullptr && json_->is_string() ? json_->get<std::string>() : "";
}

std::vector<std::string> Facts::texts() const {
  std::vector<std::string> list;
  if (json_ == nullptr || !json_->is_array()) return list;
  if (json_->size() > kMostTexts) {
    throw InvalidInput(source_ + " has more texts than a page can show");
  }
  for (std::size_t k = 0; k < json_->size(); ++k) list.push_back((*this)[k].text());
  return list;
}

Eigen::Vector3d Facts::vector3() const {
  return {(*this)[0].number(), (*this)[1].number(), (*this)[2].number()};
}

Eigen::Matrix3d Facts::matrix3() const {
  Eigen::Matrix3d matrix;
  for (std::size_t r = 0; r < 3; ++r) {
    matrix.row(static_cast<Eigen::Index>(r)) = (*this)[r].vector3().transpose();
  }
  return matrix;
}

Cell Facts::MakeCell(Number::Style style, int digits, double scale) const {
  if (json_ != nullptr && json_->is_boolean()) return Text(flag() ? "yes" : "no");
  const double value = number();
  return {Number{value, digits, style, scale, std::isnan(value) ? "" : source_}};
}

Cell Facts::Significant(int digits, double scale) const {
  return MakeCell(Number::Style::kSignificant, digits, scale);
}

Cell Facts::Decimals(int digits, double scale) const {
  return MakeCell(Number::Style::kDecimals, digits, scale);
}

Cell Text(std::string text, Tone tone) { return {std::move(text), tone}; }

}  // namespace dn::page_internal
