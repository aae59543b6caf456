#pragma once

#include <stdexcept>
#include <string>

namespace tissued::config {

// A configuration or bundle that is refused. what() is one line: `FILE: KEY: VALUE is ... LIMIT`, e.g.
// `demo.json: /simulator/iterations: 0 is below the minimum 1`. KEY is a JSON pointer (RFC 6901); where the text is not
// JSON at all the line reads `FILE: line 3, column 14: ...`. FILE is `--set KEY=VALUE` where an override is to blame.
class ConfigError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace tissued::config
