#pragma once

#include <dn/report/document.h>
#include <dn/report/json.h>

namespace dn::internal {

/// A chart as page.js draws it; numbers with the seven digits that a picture can show.
Json ChartJson(const Chart& chart);

/// JSON for the inside of a script element: no text in it can end the element.
std::string EscapedJson(const Json& json);

}  // namespace dn::internal
