#include "daemon/watch_page.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "daemon/alarm_report.hpp"
#include "daemon/confidence.hpp"
#include "daemon/text_table.hpp"

namespace tissued::daemon {
namespace {

using protocol::Validity;

constexpr std::size_t kNarrow = 56;      // columns; below it only what matters most is shown
constexpr std::size_t kFixedLines = 11;  // of the page, all but the targets

enum class Colour { plain, dim, bold, green, yellow, red };

// Words and colours of one style of terminal.
class Brush {
 public:
  explicit Brush(const TerminalStyle& style) : style_(style) {}

  std::string operator()(Colour colour, const std::string& text) const {
    constexpr std::array<const char*, 6> kCodes{"", "\x1b[2m", "\x1b[1m", "\x1b[32m", "\x1b[33m", "\x1b[31m"};
    if (!style_.colour || colour == Colour::plain) return text;
    return kCodes[static_cast<std::size_t>(colour)] + text + "\x1b[0m";
  }
  const char* dot() const { return style_.unicode ? " · " : " | "; }
  const char* lamp() const { return style_.unicode ? "●" : "*"; }
  const char* plus_minus() const { return style_.unicode ? "±95 %" : "+-95%"; }
  // 0 to 1 as a bar one column wide.
  std::string bar(double share) const {
    constexpr std::array<const char*, 8> kBlocks{"▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
    constexpr const char* kAscii = "_.,-=+*#";
    const auto level = static_cast<std::size_t>(std::clamp(std::lround(share * 7.0), 0l, 7l));
    return style_.unicode ? kBlocks[level] : std::string(1, kAscii[level]);
  }

 private:
  TerminalStyle style_;
};

Colour colour_of(Validity validity) {
  switch (validity) {
    case Validity::valid:
      return Colour::green;
    case Validity::degraded:
      return Colour::yellow;
    case Validity::invalid:
      return Colour::red;
    case Validity::no_data:
      break;
  }
  return Colour::dim;
}

// An error within what is claimed is green, beyond it yellow, beyond twice of it red.
Colour colour_of_error(double error, std::optional<double> radius) {
  if (!radius) return Colour::plain;
  return error <= *radius ? Colour::green : error <= 2.0 * *radius ? Colour::yellow : Colour::red;
}

std::string words_with_blanks(std::string text) {
  std::ranges::replace(text, '_', ' ');
  return text;
}

// `left` and `right` at the two edges of the page.
std::string edges(const std::string& left, const std::string& right, std::size_t width) {
  const std::size_t used = display_width(left) + display_width(right);
  return left + std::string(used < width ? width - used : 1, ' ') + right;
}

std::string title_line(const WatchStatistics& statistics, const Connection& connection, const TerminalStyle& style) {
  const Brush brush(style);
  std::string title = "tissued";
  if (const auto& hello = statistics.hello()) {
    title += ' ' + std::string(hello->version.view()) + brush.dot() + std::string(hello->model.view()) + brush.dot() +
             std::string(hello->simulator.view());
  }
  return edges(brush(Colour::bold, title), brush(Colour::dim, connection.address), style.width);
}

std::string state_line(const WatchStatistics& statistics, const Connection& connection, const TerminalStyle& style,
                       std::uint64_t now_ns) {
  const Brush brush(style);
  if (!connection.answering) {
    return brush(Colour::red, std::string(brush.lamp()) + " NO ANSWER") + "  from " + connection.address + " for " +
           fixed(connection.silent, 0) + " s; asking on";
  }
  if (!statistics.latest()) return brush(Colour::dim, std::string(brush.lamp()) + " connected");
  const protocol::Predictions& frame = statistics.latest()->frame;
  std::string word = words_with_blanks(protocol::to_string(frame.validity));
  std::ranges::transform(word, word.begin(), [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  std::string left = brush(colour_of(frame.validity), std::string(brush.lamp()) + ' ' + word);
  if (frame.validity == Validity::no_data) return left + "  no frame from the tracker yet: targets at rest";
  left += "  frame " + std::to_string(frame.tracker_frame) + brush.dot() + age_text(statistics.age_ns(now_ns));
  const std::string right =
      fixed(statistics.rate_hz(now_ns), 1) + " Hz" + brush.dot() + std::to_string(statistics.lost()) + " lost";
  return edges(left, right, style.width);
}

// Why the answer is not quite valid; empty where it is.
std::string reasons_line(const WatchStatistics& statistics, const Connection& connection, const TerminalStyle& style) {
  if (!connection.answering || !statistics.latest()) return {};
  std::string line;
  for (const std::string& reason : reason_names(statistics.latest()->frame.reasons)) {
    line += (line.empty() ? "  " : ", ") + words_with_blanks(reason);
  }
  return Brush(style)(colour_of(statistics.latest()->frame.validity), line);
}

// The scale of all traces: the largest error in any of them.
double trace_scale(const WatchStatistics& statistics) {
  double most = 0.0;
  for (const WatchedTarget& target : statistics.targets()) {
    for (const double error : target.trace) most = std::isnan(error) ? most : std::max(most, error);
  }
  return most;
}

std::string trace_text(const std::deque<double>& trace, std::size_t columns, double scale, const Brush& brush) {
  std::string text;
  const std::size_t first = trace.size() > columns ? trace.size() - columns : 0;
  for (std::size_t i = first; i < trace.size(); ++i) {
    text += std::isnan(trace[i]) || scale <= 0.0 ? " " : brush.bar(trace[i] / scale);
  }
  return text;
}

constexpr std::size_t kNameColumns = 10, kNumberColumns = 9;

std::string target_line(const WatchedTarget& target, double scale, const TerminalStyle& style) {
  const Brush brush(style);
  const auto cell = [](double value, int digits) { return pad_to(fixed(value, digits), kNumberColumns, true); };
  std::string line = pad_to(target.name, kNameColumns, false);
  if (!target.latest) return line;
  const auto radius = radius_95(target.latest->covariance);
  const auto& error = target.error;
  if (style.width >= kNarrow) {
    for (const double coordinate : target.latest->position) line += cell(coordinate, 2);
  }
  line += cell(radius.value_or(NAN), 2);
  line += brush(error ? colour_of_error(*error, radius) : Colour::dim, cell(error.value_or(NAN), 2));
  const std::size_t used = display_width(line) + 2;
  if (used + 8 < style.width)
    line += "  " + brush(Colour::dim, trace_text(target.trace, style.width - used, scale, brush));
  return line;
}

std::vector<std::string> target_lines(const WatchStatistics& statistics, const TerminalStyle& style) {
  const Brush brush(style);
  const auto cell = [](const char* text) { return pad_to(text, kNumberColumns, true); };
  std::string head = pad_to("target", kNameColumns, false);
  if (style.width >= kNarrow) head += cell("x") + cell("y") + cell("z");
  head += cell(brush.plus_minus()) + cell("error") + "  mm";
  const double scale = trace_scale(statistics);
  if (scale > 0.0) head += ", full bar " + fixed(scale, 2);
  std::vector<std::string> lines{brush(Colour::dim, head)};
  const std::size_t room = style.height > kFixedLines + 2 ? style.height - kFixedLines : 2;
  const auto& targets = statistics.targets();
  const std::size_t shown = targets.size() <= room ? targets.size() : room - 1;
  for (std::size_t i = 0; i < shown; ++i) lines.push_back(target_line(targets[i], scale, style));
  if (shown < targets.size()) {
    lines.push_back(brush(Colour::dim, "and " + std::to_string(targets.size() - shown) + " more"));
  }
  return lines;
}

std::string latency_text(const char* name, const LatencyWindow& window) {
  const auto cell = [](double ms) { return pad_to(fixed(ms, 2), 8, true); };
  const DurationPercentiles durations = percentiles_ms(window);
  return pad_to(name, 17, false) + "p50" + cell(durations.p50) + "  p99" + cell(durations.p99) + "  max" +
         cell(durations.max) + "  ms";
}

std::string work_line(const WatchStatistics& statistics, const Brush& brush) {
  const protocol::Predictions& frame = statistics.latest()->frame;
  return "markers " + std::to_string(frame.markers_used) + " used of " + std::to_string(frame.markers_seen) + " seen" +
         brush.dot() + "innovation " + fixed(frame.innovation_rms, 3) + " mm" + brush.dot() +
         std::to_string(frame.iterations) + " iterations";
}

std::string pad_line(const WatchStatistics& statistics, const Brush& brush) {
  std::string line;
  for (const protocol::PadReaction& pad : statistics.latest()->pads) {
    const std::string name = pad.index < statistics.pad_names().size() ? statistics.pad_names()[pad.index] : "?";
    const double force = std::hypot(pad.force[0], pad.force[1], pad.force[2]);
    line += (line.empty() ? "pads    " : brush.dot()) + name + ' ' + fixed(force, 2) + " N";
  }
  return line;
}

}  // namespace

std::vector<std::string> watch_page(const WatchStatistics& statistics, const Connection& connection,
                                    const TerminalStyle& style, std::uint64_t now_ns) {
  const Brush brush(style);
  std::vector<std::string> lines{title_line(statistics, connection, style),
                                 state_line(statistics, connection, style, now_ns),
                                 reasons_line(statistics, connection, style)};
  if (connection.answering && statistics.latest() && statistics.latest()->frame.alarm.raised)
    lines.push_back(brush(Colour::red, "  a diagnosis is due: " + alarm_text(statistics.latest()->frame.alarm)));
  for (std::string& line : target_lines(statistics, style)) lines.push_back(std::move(line));
  if (statistics.latest()) {
    lines.insert(lines.end(), {"", latency_text("receive to send", statistics.recent_latency()),
                               latency_text("step", statistics.recent_step()), work_line(statistics, brush),
                               pad_line(statistics, brush)});
  }
  lines.push_back(brush(Colour::dim, "Ctrl-C ends"));
  return lines;
}

}  // namespace tissued::daemon
