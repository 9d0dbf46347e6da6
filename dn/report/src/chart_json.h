#pragma once

#include <dn/report/document.h>
#include <dn/report/json.h>

namespace dn::report_internal {

/// Returns a chart as JSON for page.js, with seven digits, which are enough for a picture.
Json ChartJson(const Chart& chart);

/// Returns JSON for the inside of a script element; none of its texts can end the element.
std::string EscapeJson(const Json& json);

}  // namespace dn::report_internal
