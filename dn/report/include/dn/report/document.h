#pragma once

#include <string>
#include <variant>
#include <vector>

namespace dn {

/// Rating of the statement in a text or cell, which selects its colour.
enum class Tone { kPlain, kGood, kDoubtful, kBad };

/// A number as displayed, with its full value.
struct Number {
  enum class Style {
    kDecimals,     ///< `digits` after the decimal point
    kSignificant,  ///< `digits` significant digits
  };
  double value = 0.0;  ///< as in the result file; not finite if there is no value
  int digits = 4;
  Style style = Style::kSignificant;
  double scale = 1.0;       ///< the displayed number is scale * value
  std::string source = {};  ///< its place in a file: "result.json#/boresight/sigma_deg/0"
};

/// Returns the displayed digits; a dash if the value is not finite.
std::string ToText(const Number& number);

/// One cell of a table.
struct Cell {
  std::variant<std::string, Number> content;
  Tone tone = Tone::kPlain;
};

/// A table; each row has one cell per column.
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

/// Preformatted lines, such as a configuration or the table of a program.
struct Listing {
  std::string title;
  std::string text;
};

/// A curve of y over x, with a band from `low` to `high` if these are given.
struct Curve {
  std::string label;
  std::vector<double> x;
  std::vector<double> y;
  std::vector<double> low = {};
  std::vector<double> high = {};
  bool points = false;  ///< false: joined by lines
};

/// A chart of curves into which the reader can zoom.
struct SeriesChart {
  std::string title;
  std::string x_label;
  std::string y_label;
  std::vector<Curve> curves;
  bool log_scales = false;  ///< true: both axes are logarithmic
};

/// A chart of point clouds, with `curves` drawn over them.
struct ScatterChart {
  std::string title;
  std::string x_label;
  std::string y_label;
  std::vector<Curve> clouds;
  std::vector<Curve> curves = {};
};

/// A bar from 0 to `value`, and an interval from `low` to `high`. NaN omits the bar or the
/// interval.
struct Bar {
  std::string label;
  std::string group;
  double value = 0.0;
  double low = 0.0;
  double high = 0.0;
};

/// A bar chart by label; the bars of a label are grouped next to each other.
struct BarChart {
  std::string title;
  std::string x_label;
  std::vector<Bar> bars;
};

/// Points whose colour shows the logarithm of a value between `low` and `high`.
struct ValuedPoints {
  std::string label = {};
  std::vector<double> x = {};
  std::vector<double> y = {};
  std::vector<double> value = {};
  double low = 0.0;
  double high = 0.0;
};

/// A map of areas, lines and points in m, with one scale for both axes. If there are valued points,
/// only these are coloured.
struct MapChart {
  std::string title;
  std::vector<Curve> lines;
  std::vector<Curve> points = {};
  std::vector<Curve> areas = {};  ///< corners of polygons
  ValuedPoints valued = {};
};

/// A matrix whose values from -1 to 1 are shown as colours.
struct HeatMap {
  std::string title;
  std::vector<std::string> rows;
  std::vector<std::string> columns;
  std::vector<std::vector<double>> values;  ///< by row; NaN leaves a cell empty
};

using Chart = std::variant<SeriesChart, ScatterChart, BarChart, MapChart, HeatMap>;
using Content = std::variant<Paragraph, Table, Listing, Chart>;

struct Section {
  std::string title;
  std::vector<Content> contents;
  bool folded = false;  ///< true: closed until the reader opens it
};

/// Verdict on the reliability of a result, with its reasons and key figures.
struct Headline {
  std::string word;    ///< "calibrated"
  std::string answer;  ///< one sentence: the meaning of the word for this result
  Tone tone = Tone::kPlain;
  std::vector<std::string> reasons = {};
  std::vector<Table> figures = {};     ///< the few most important numbers
  std::vector<std::string> next = {};  ///< recommended actions
};

/// Content of a page as values; renderers determine its layout.
struct Document {
  std::string title;
  std::string subtitle;
  std::vector<Headline> headlines = {};
  std::vector<Section> sections = {};
  /// Printed instead of all of the above, with a line for date and signature; not shown on a
  /// screen.
  std::vector<Section> certificate = {};
};

/// Returns a curve with at most `most` points for display. It keeps the smallest and the largest
/// ordinate of each interval, and the limits of the widest band.
Curve ThinCurve(const Curve& curve, std::size_t most);

/// Returns one HTML file with its style, charts and data; it needs no network. All texts are
/// escaped.
std::string ToHtml(const Document& document);

/// Returns the headlines and tables as text for a terminal.
std::string ToText(const Document& document);

}  // namespace dn
