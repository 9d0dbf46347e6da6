#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "picked_columns.h"
#include "text_sample.h"

namespace dn::files_internal {

/// Returns whether a text is a date or a time of day, such as "21/09/2023" or "09:49:42.0".
bool IsCalendarText(std::string_view text);

/// Returns what to do with a calendar time that has another form.
std::string CalendarAdvice(std::string_view column, std::string_view text);

/// Says which order of day and month is assumed; empty if the date leaves no choice.
std::string DateNote(const TextSample& sample);

/// Says why a text has no time that increases in the stated steps.
std::string TimeReason(const TextSample& sample, const std::string& steps);

/// Says which of some columns has text instead of numbers.
std::string TextReason(const TextSample& sample, const std::vector<NamedColumn>& columns);

}  // namespace dn::files_internal
