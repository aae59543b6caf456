#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace tissued::daemon {

/// What standard output can show.
struct TerminalStyle {
  std::size_t width = 80;
  std::size_t height = 24;
  bool colour = true;
  bool unicode = true;  ///< else ASCII only
};

bool stdout_is_terminal();

/// Writes out what is left; false where any of what was printed could not be written, as on a full disk.
bool stdout_is_written();

/// The terminal at standard output now; a user may resize it any time. NO_COLOR and the locale are respected.
TerminalStyle terminal_style();

/// `line` cut to `width` columns; escape sequences take none and are all kept.
std::string clip(const std::string& line, std::size_t width);

/// Takes the terminal's alternate screen as long as it lives, so that what stood there comes back. Every page is drawn
/// over the one before with one write: nothing flickers.
class FullScreen {
 public:
  FullScreen();
  ~FullScreen();
  FullScreen(const FullScreen&) = delete;
  FullScreen& operator=(const FullScreen&) = delete;

  /// Lines beyond the terminal's height are left out.
  void draw(const std::vector<std::string>& lines, const TerminalStyle& style);
};

}  // namespace tissued::daemon
