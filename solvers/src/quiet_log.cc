#include "quiet_log.h"

#include <glog/logging.h>

#include <mutex>

namespace dn {
namespace {

std::mutex g_log_mutex;
int g_living = 0;
int g_level = 0;  // log threshold before the first object

}  // namespace

QuietLog::QuietLog() {
  const std::lock_guard lock(g_log_mutex);
  if (g_living++ > 0) return;
  g_level = FLAGS_minloglevel;
  FLAGS_minloglevel = google::FATAL;
}

QuietLog::~QuietLog() {
  const std::lock_guard lock(g_log_mutex);
  if (--g_living == 0) FLAGS_minloglevel = g_level;
}

}  // namespace dn
