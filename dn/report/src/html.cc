#include <dn/report/document.h>
#include <fmt/format.h>

#include <string_view>

#include "chart_json.h"

namespace dn {
namespace report_internal {

// Contents of the files in dn/report/page and dn/report/vendor.
extern const std::string_view page_style, page_script, uplot_style, uplot_script, uplot_version,
    uplot_licence, d3_script, d3_version, d3_licence, plot_script, plot_version, plot_licence;

}  // namespace report_internal
namespace {

// The page loads nothing from outside, even if a text of the flight contains HTML.
constexpr const char* kPolicy =
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:; "
    "base-uri 'none'; form-action 'none'";

std::string EscapeHtml(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        // HTML allows only tab and line feed among the control characters.
        out += static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t' ? ' ' : c;
    }
  }
  return out;
}

std::string Element(const char* name, const std::string& text, const char* style = nullptr) {
  const std::string attribute = style == nullptr ? "" : fmt::format(" class=\"{}\"", style);
  return text.empty() ? "" : fmt::format("<{0}{1}>{2}</{0}>\n", name, attribute, EscapeHtml(text));
}

const char* ToneClass(Tone tone) {
  switch (tone) {
    case Tone::kPlain:
      return "plain";
    case Tone::kGood:
      return "good";
    case Tone::kDoubtful:
      return "doubtful";
    case Tone::kBad:
      return "bad";
  }
  return "";
}

/// Renders a page, and collects its charts.
class Page {
 public:
  std::string Render(const Document& document) {
    std::string body = "<header>\n" + Element("h1", document.title) +
                       Element("p", document.subtitle, "subtitle") + "</header>\n<main>\n";
    body += "<div class=\"verdicts\">\n";
    for (const Headline& headline : document.headlines) body += Html(headline);
    body += "</div>\n" + Contents(document) +
            "<noscript><p>Charts need JavaScript; the tables have the numbers.</p></noscript>\n";
    for (std::size_t k = 0; k < document.sections.size(); ++k) {
      body += Html(document.sections[k], k);
    }
    body += Certificate(document) + "</main>\n<footer>\n" + Libraries() + "</footer>\n";
    return Head(document) +
           (document.certificate.empty() ? "<body>\n" : "<body class=\"certified\">\n") + body +
           Scripts() + "</body>\n</html>\n";
  }

 private:
  std::string Head(const Document& document) const {
    std::string head = fmt::format(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
        "<meta http-equiv=\"Content-Security-Policy\" content=\"{}\">\n"
        "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
        "<meta name=\"color-scheme\" content=\"light dark\">\n<link rel=\"icon\" "
        "href=\"data:,\">\n",
        kPolicy);
    head += Element("title", document.title) + "<style>\n";
    if (has_series_) head += report_internal::uplot_style;
    head += report_internal::page_style;
    return head + "</style>\n</head>\n";
  }

  std::string Scripts() const {
    if (charts_.empty()) return "";
    const auto script = [](std::string_view text) {
      return "<script>\n" + std::string(text) + "\n</script>\n";
    };
    std::string text = "<script type=\"application/json\" id=\"dn-data\">" +
                       report_internal::EscapeJson({{"charts", charts_}}) + "</script>\n";
    if (has_series_) text += script(report_internal::uplot_script);
    if (has_pictures_)
      text += script(report_internal::d3_script) + script(report_internal::plot_script);
    return text + script(report_internal::page_script);
  }

  std::string Libraries() const {
    std::string text;
    const auto add = [&](std::string_view version, std::string_view licence) {
      text += Element("h3", std::string(version)) + Element("pre", std::string(licence));
    };
    if (has_series_) add(report_internal::uplot_version, report_internal::uplot_licence);
    if (has_pictures_) {
      add(report_internal::plot_version, report_internal::plot_licence);
      add(report_internal::d3_version, report_internal::d3_licence);
    }
    if (text.empty()) return "";
    return "<details><summary>Libraries that draw the charts, and their licences</summary>\n" +
           text + "</details>\n";
  }

  std::string Html(const Headline& headline) {
    std::string text =
        fmt::format("<section class=\"verdict {}\">\n<div>\n", ToneClass(headline.tone));
    text += Element("h2", headline.word) + Element("p", headline.answer, "answer");
    text += List("Why", headline.reasons) + "</div>\n<div>\n";
    for (const Table& table : headline.figures) text += Html(table);
    return text + List("What to do next", headline.next) + "</div>\n</section>\n";
  }

  std::string Certificate(const Document& document) {
    if (document.certificate.empty()) return "";
    std::string text = "<div class=\"certificate\">\n";
    for (std::size_t k = 0; k < document.certificate.size(); ++k) {
      text += Html(document.certificate[k], document.sections.size() + k);
    }
    return text + Element("p", document.subtitle) +
           "<p>Date <span class=\"today\">____________</span> Signature "
           "________________________</p>\n</div>\n";
  }

  static std::string List(const char* title, const std::vector<std::string>& items) {
    if (items.empty()) return "";
    std::string text = Element("h3", title) + "<ul>\n";
    for (const std::string& item : items) text += Element("li", item);
    return text + "</ul>\n";
  }

  static std::string Contents(const Document& document) {
    std::string text = "<nav>";
    for (std::size_t k = 0; k < document.sections.size(); ++k) {
      text += fmt::format("<a href=\"#s{}\">{}</a>\n", k, EscapeHtml(document.sections[k].title));
    }
    return text + "</nav>\n";
  }

  std::string Html(const Section& section, std::size_t number) {
    std::string body;
    for (const Content& content : section.contents) {
      body += std::visit([&](const auto& one) { return Html(one); }, content);
    }
    const std::string title = EscapeHtml(section.title);
    return section.folded ? fmt::format(
                                "<section id=\"s{}\"><details><summary><h2>{}</h2></summary>\n{}"
                                "</details></section>\n",
                                number, title, body)
                          : fmt::format("<section id=\"s{}\">\n<h2>{}</h2>\n{}</section>\n", number,
                                        title, body);
  }

  static std::string Html(const Paragraph& paragraph) {
    return Element("p", paragraph.text, ToneClass(paragraph.tone));
  }

  static std::string Html(const Listing& listing) {
    return Element("h3", listing.title) + Element("pre", listing.text);
  }

  static std::string Html(const Cell& cell) {
    const auto* number = std::get_if<Number>(&cell.content);
    if (number == nullptr) {
      return fmt::format("<td class=\"{}\">{}</td>", ToneClass(cell.tone),
                         EscapeHtml(std::get<std::string>(cell.content)));
    }
    const std::string source =
        number->source.empty()
            ? ""
            : fmt::format(" data-source=\"{}\" title=\"{}\"", EscapeHtml(number->source),
                          EscapeHtml(fmt::format("{} in {}", number->value, number->source)));
    return fmt::format("<td class=\"number {}\" data-value=\"{}\" data-scale=\"{}\"{}>{}</td>",
                       ToneClass(cell.tone), number->value, number->scale, source, ToText(*number));
  }

  static std::string Html(const Table& table) {
    std::string text = Element("h3", table.title) + "<div class=\"wide\"><table>\n<thead><tr>";
    for (const std::string& column : table.columns) text += "<th>" + EscapeHtml(column) + "</th>";
    text += "</tr></thead>\n<tbody>\n";
    for (const auto& row : table.rows) {
      text += "<tr>";
      for (const Cell& cell : row) text += Html(cell);
      text += "</tr>\n";
    }
    return text + "</tbody></table></div>\n" + Element("p", table.note, "note");
  }

  std::string Html(const Chart& chart) {
    const bool series = std::holds_alternative<SeriesChart>(chart);
    (series ? has_series_ : has_pictures_) = true;
    charts_.push_back(report_internal::ChartJson(chart));
    const std::string title = std::visit([](const auto& one) { return one.title; }, chart);
    return fmt::format(
        "<figure data-chart=\"{}\"><figcaption>{}</figcaption><div></div></figure>\n",
        charts_.size() - 1, EscapeHtml(title));
  }

  Json charts_ = Json::array();
  bool has_series_ = false;
  bool has_pictures_ = false;
};

}  // namespace

std::string ToHtml(const Document& document) { return Page().Render(document); }

}  // namespace dn
