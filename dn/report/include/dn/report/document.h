#pragma once

#include <string>
#include <variant>
#include <vector>

namespace dn {

/// How good a thing is that a text or a cell says.
enum class Tone { kPlain, kGood, kDoubtful, kBad };

/// A number as a person reads it, with the value behind it.
struct Number {
  enum class Style {
    kDecimals,     ///< `digits` after the point
    kSignificant,  ///< `digits` in all
  };
  double value = 0.0;  ///< as the result file has it; not finite: there is none
  int digits = 4;
  Style style = Style::kSignificant;
  double scale = 1.0;       ///< shown is scale * value
  std::string source = {};  ///< where a file has it, "result.json#/boresight/sigma_deg/0"
};

/// The digits that are shown; a dash where there is no number.
std::string ToText(const Number& number);

/// One cell of a table.
struct Cell {
  std::variant<std::string, Number> content;
  Tone tone = Tone::kPlain;
};

/// Rows of as many cells as there are columns.
struct Table {
  std::string title;
  std::vector<std::string> columns;
  std::vector<std::vector<Cell>> rows;
  std::string note = {};
};

struct Paragraph {
  std::string text;
  Tone tone = Tone::kPlain;
};

/// Lines that keep their form: a configuration, a table of a program.
struct Listing {
  std::string title;
  std::string text;
};

/// Ordinates over an abscissa, with a band from `low` to `high` where these are given.
struct Curve {
  std::string label;
  std::vector<double> x;
  std::vector<double> y;
  std::vector<double> low = {};
  std::vector<double> high = {};
  bool points = false;  ///< else joined
};

/// Curves that one zooms into.
struct SeriesChart {
  std::string title;
  std::string x_label;
  std::string y_label;
  std::vector<Curve> curves;
  bool log_scales = false;  ///< both axes
};

/// Clouds of points; `curves` are drawn over them.
struct ScatterChart {
  std::string title;
  std::string x_label;
  std::string y_label;
  std::vector<Curve> clouds;
  std::vector<Curve> curves = {};
};

/// A bar from 0 to `value`, and the interval from `low` to `high`; NaN: no bar, no interval.
struct Bar {
  std::string label;
  std::string group;
  double value = 0.0;
  double low = 0.0;
  double high = 0.0;
};

/// Bars by label, and beside each other by group.
struct BarChart {
  std::string title;
  std::string x_label;
  std::vector<Bar> bars;
};

/// Points whose colour is a value, between `low` and `high` by its logarithm.
struct ValuedPoints {
  std::string label = {};
  std::vector<double> x = {};
  std::vector<double> y = {};
  std::vector<double> value = {};
  double low = 0.0;
  double high = 0.0;
};

/// Areas, lines and points seen from above, one scale for both axes, m. Where there are valued
/// points, these alone are coloured.
struct MapChart {
  std::string title;
  std::vector<Curve> lines;
  std::vector<Curve> points = {};
  std::vector<Curve> areas = {};  ///< corners of polygons
  ValuedPoints valued = {};
};

/// A matrix in colours from -1 to 1.
struct HeatMap {
  std::string title;
  std::vector<std::string> rows;
  std::vector<std::string> columns;
  std::vector<std::vector<double>> values;  ///< by row; NaN: none
};

using Chart = std::variant<SeriesChart, ScatterChart, BarChart, MapChart, HeatMap>;
using Content = std::variant<Paragraph, Table, Listing, Chart>;

struct Section {
  std::string title;
  std::vector<Content> contents;
  bool folded = false;  ///< for the few who want to know
};

/// The answer to "may I rely on it?", and what stands behind it.
struct Headline {
  std::string word;    ///< "calibrated"
  std::string answer;  ///< one sentence that says what the word means here
  Tone tone = Tone::kPlain;
  std::vector<std::string> reasons = {};
  std::vector<Table> figures = {};     ///< the few numbers that matter most
  std::vector<std::string> next = {};  ///< what to do
};

/// What a page says, as values: how it looks is for its renderers.
struct Document {
  std::string title;
  std::string subtitle;
  std::vector<Headline> headlines = {};
  std::vector<Section> sections = {};
};

/// The points of a curve that a screen shows: at most `most`, the least and the greatest ordinate
/// (and the widest band) of each stretch among them.
Curve Thinned(const Curve& curve, std::size_t most);

/// One HTML file with its style, its charts and their data; it needs no network. Texts are escaped
/// wherever they stand.
std::string ToHtml(const Document& document);

/// Headlines and tables for a terminal.
std::string ToText(const Document& document);

}  // namespace dn
