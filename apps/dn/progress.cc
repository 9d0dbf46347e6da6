#include "progress.h"

#include <dn/report/json.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>

#include "command.h"
#include "shown_text.h"

namespace dn::apps {
namespace {

constexpr double kMinJsonInterval_s = 0.1;
/// Shorter remaining times are not displayed.
constexpr double kMinTimeLeft_s = 5.0;

std::string Text(const Share& share) {
  if (share.of == 1.0) return fmt::format("{:.0f} %", 100.0 * share.done);
  return fmt::format("{:.0f} of {:.0f}{}{}", share.done, share.of, share.things.empty() ? "" : " ",
                     share.things);
}

std::string TimeText(double time_s) {
  if (time_s < 90.0) return fmt::format("{:.0f} s", time_s);
  if (time_s < 5400.0) return fmt::format("{:.0f} min", time_s / 60.0);
  return fmt::format("{:.1f} h", time_s / 3600.0);
}

}  // namespace

std::optional<double> TimeLeft::At(const Share& share, double now_s) {
  const bool same =
      begun_ && share.of == last_.of && share.things == last_.things && share.done >= last_.done;
  last_ = share;
  if (!same) {
    begun_ = true;
    first_ = share;
    first_s_ = now_s;
    return std::nullopt;
  }
  const double grown = share.done - first_.done;
  if (grown <= 0.0) return std::nullopt;
  return (now_s - first_s_) * (share.of - share.done) / grown;
}

Progress::Progress(std::string command, bool as_json)
    : command_(std::move(command)), as_json_(as_json), terminal_(isatty(STDERR_FILENO) != 0) {}

Progress::~Progress() { EndLine(); }

void Progress::EndLine() {
  if (line_open_) std::fputc('\n', stderr);
  line_open_ = false;
}

void Progress::Stage(const std::string& stage, const std::string& detail) {
  Show({stage, detail, {}, {}});
}

void Progress::Stage(const std::string& stage, const Share& share) {
  const std::optional<double> left_s = time_left_.At(share, watch_.seconds());
  std::string detail = Text(share);
  if (!as_json_ && left_s && *left_s > kMinTimeLeft_s) {
    detail += ", about " + TimeText(*left_s) + " left";
  }
  Show({stage, detail, share, left_s});
}

void Progress::Show(const Moment& moment) {
  const bool entered = moment.stage != stage_;
  stage_ = moment.stage;
  if (entered) {
    std::erase(stages_, stage_);
    stages_.push_back(stage_);
  }
  if (as_json_) {
    ShowJson(moment, entered);
    return;
  }
  const std::string text =
      Printable("dn " + command_ + ": " + moment.stage +
                (moment.detail.empty() ? std::string() : " (" + moment.detail + ")"));
  if (terminal_) {
    if (entered) EndLine();
    const std::string line = "\r\033[K" + text;
    std::fwrite(line.data(), 1, line.size(), stderr);
    std::fflush(stderr);
    line_open_ = true;
  } else if (entered) {
    Say(text);
  }
}

void Progress::ShowJson(const Moment& moment, bool entered) {
  const double now_s = watch_.seconds();
  const bool complete = moment.share && moment.share->done >= moment.share->of;
  if (!entered && !complete && now_s - last_json_s_ < kMinJsonInterval_s) return;
  last_json_s_ = now_s;
  Json line = {{"command", command_}, {"stage", moment.stage}, {"elapsed_s", now_s}};
  if (!moment.detail.empty()) line["detail"] = moment.detail;
  if (moment.share) {
    line["done"] = moment.share->done;
    line["of"] = moment.share->of;
  }
  if (moment.left_s) line["left_s"] = *moment.left_s;
  SayJson(line);
}

void Progress::Warn(const std::string& message) {
  EndLine();
  Say("dn " + command_ + ": warning: " + message);
}

}  // namespace dn::apps
