#include "daemon/terminal.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <cstdlib>
#include <string_view>

namespace tissued::daemon {
namespace {

constexpr std::string_view kEnter = "\x1b[?1049h\x1b[?25l";  // alternate screen, cursor hidden
constexpr std::string_view kLeave = "\x1b[?25h\x1b[?1049l";

void write_all(std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(STDOUT_FILENO, text.data(), text.size());
    if (written <= 0) return;  // a terminal that is gone needs no page
    text.remove_prefix(static_cast<std::size_t>(written));
  }
}

bool locale_is_utf8() {
  for (const char* variable : {"LC_ALL", "LC_CTYPE", "LANG"}) {
    const char* value = std::getenv(variable);
    if (value == nullptr || *value == '\0') continue;
    std::string upper(value);
    std::ranges::transform(upper, upper.begin(), [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
    return upper.find("UTF-8") != std::string::npos || upper.find("UTF8") != std::string::npos;
  }
  return false;
}

}  // namespace

bool stdout_is_written() { return std::fflush(stdout) == 0 && std::ferror(stdout) == 0; }

bool stdout_is_terminal() { return isatty(STDOUT_FILENO) == 1; }

TerminalStyle terminal_style() {
  TerminalStyle style;
  winsize size{};
  if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 && size.ws_row > 0) {
    style.width = size.ws_col;
    style.height = size.ws_row;
  }
  const char* no_colour = std::getenv("NO_COLOR");
  style.colour = no_colour == nullptr || *no_colour == '\0';
  style.unicode = locale_is_utf8();
  return style;
}

std::string clip(const std::string& line, std::size_t width) {
  std::string clipped;
  std::size_t columns = 0;
  for (std::size_t i = 0; i < line.size();) {
    std::size_t end = i + 1;
    if (line[i] == '\x1b') {
      while (end < line.size() && std::isalpha(static_cast<unsigned char>(line[end])) == 0) ++end;
      end = std::min(end + 1, line.size());
    } else {
      while (end < line.size() && (static_cast<unsigned char>(line[end]) & 0xC0) == 0x80) ++end;
      if (++columns > width) {
        i = end;
        continue;
      }
    }
    clipped.append(line, i, end - i);
    i = end;
  }
  return clipped;
}

FullScreen::FullScreen() { write_all(kEnter); }

FullScreen::~FullScreen() { write_all(kLeave); }

void FullScreen::draw(const std::vector<std::string>& lines, const TerminalStyle& style) {
  std::string page = "\x1b[H";
  const std::size_t count = std::min(lines.size(), style.height);
  for (std::size_t i = 0; i < count; ++i) {
    if (i > 0) page += "\r\n";
    page += "\x1b[2K" + clip(lines[i], style.width);
  }
  page += "\x1b[0J";  // nothing stays below of a longer page
  write_all(page);
}

}  // namespace tissued::daemon
