#include "chart_json.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>

namespace dn::report_internal {
namespace {

Json ToDrawingJson(double value) {
  if (!std::isfinite(value)) return nullptr;
  return std::strtod(fmt::format("{:.7g}", value).c_str(), nullptr);
}

Json ToDrawingJson(const std::vector<double>& values) {
  Json list = Json::array();
  for (const double value : values) list.push_back(ToDrawingJson(value));
  return list;
}

Json ToDrawingJson(const Curve& curve) {
  Json json = {
      {"label", curve.label}, {"x", ToDrawingJson(curve.x)}, {"y", ToDrawingJson(curve.y)}};
  if (!curve.low.empty()) {
    json["low"] = ToDrawingJson(curve.low);
    json["high"] = ToDrawingJson(curve.high);
  }
  if (curve.points) json["points"] = true;
  return json;
}

Json ToDrawingJson(const Bar& bar) {
  return {{"label", bar.label},
          {"group", bar.group},
          {"value", ToDrawingJson(bar.value)},
          {"low", ToDrawingJson(bar.low)},
          {"high", ToDrawingJson(bar.high)}};
}

template <class T>
Json List(const std::vector<T>& values) {
  Json list = Json::array();
  for (const T& value : values) list.push_back(ToDrawingJson(value));
  return list;
}

Json Axes(const char* type, const auto& chart) {
  return {{"type", type}, {"title", chart.title}, {"x", chart.x_label}, {"y", chart.y_label}};
}

Json ToDrawingJson(const SeriesChart& chart) {
  Json json = Axes("series", chart);
  json["curves"] = List(chart.curves);
  json["log"] = chart.log_scales;
  return json;
}

Json ToDrawingJson(const ScatterChart& chart) {
  Json json = Axes("scatter", chart);
  json["clouds"] = List(chart.clouds);
  json["curves"] = List(chart.curves);
  return json;
}

Json ToDrawingJson(const BarChart& chart) {
  return {
      {"type", "bars"}, {"title", chart.title}, {"x", chart.x_label}, {"bars", List(chart.bars)}};
}

Json ToDrawingJson(const ValuedPoints& points) {
  if (points.x.empty()) return nullptr;
  return {{"label", points.label},
          {"x", ToDrawingJson(points.x)},
          {"y", ToDrawingJson(points.y)},
          {"value", ToDrawingJson(points.value)},
          {"low", ToDrawingJson(points.low)},
          {"high", ToDrawingJson(points.high)}};
}

Json ToDrawingJson(const MapChart& chart) {
  return {{"type", "map"},
          {"title", chart.title},
          {"lines", List(chart.lines)},
          {"points", List(chart.points)},
          {"areas", List(chart.areas)},
          {"valued", ToDrawingJson(chart.valued)}};
}

Json ToDrawingJson(const HeatMap& chart) {
  return {{"type", "heat"},
          {"title", chart.title},
          {"rows", chart.rows},
          {"columns", chart.columns},
          {"values", List(chart.values)}};
}

}  // namespace

Json ChartJson(const Chart& chart) {
  return std::visit([](const auto& one) { return ToDrawingJson(one); }, chart);
}

std::string EscapeJson(const Json& json) {
  std::string text;
  for (const char c : json.dump(-1, ' ', true, Json::error_handler_t::replace)) {
    switch (c) {
      case '<':
      case '>':
      case '&':
        text += fmt::format("\\u{:04x}", static_cast<int>(c));
        break;
      default:
        text += c;
    }
  }
  return text;
}

}  // namespace dn::report_internal
