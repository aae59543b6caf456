#include "config/json_reader.hpp"

#include "tests/config/bundle_folder.hpp"

using namespace tissued::config;

namespace {

std::string parse_refusal(const std::string& text) {
  return refusal([&] { parse_json(text, "x.json"); });
}

}  // namespace

TEST_CASE("JSON text is read in its own order") {
  const Json root = parse_json(R"({"b": [1, -2, 2.5, "c", true, null, {}], "a": {"z": 0, "y": []}})", "x.json");
  CHECK(root.dump() == R"({"b":[1,-2,2.5,"c",true,null,{}],"a":{"z":0,"y":[]}})");
}

TEST_CASE("Syntax errors name line and column on one line") {
  CHECK(parse_refusal("{\n  \"a\": 1,\n  \"b\" 2\n}") ==
        "x.json: line 3, column 7: syntax error while parsing object separator - unexpected number literal; expected "
        "':'");
  CHECK(parse_refusal("") ==
        "x.json: line 1, column 1: syntax error while parsing value - unexpected end of input; expected '[', '{', or a "
        "literal");
  CHECK(parse_refusal("{\"a\": 1} x").rfind("x.json: line 1, column 10: ", 0) == 0);
  CHECK(parse_refusal("{\"a\":\n\n  NaN}").rfind("x.json: line 3, column 3: ", 0) == 0);
  CHECK(parse_refusal("{\"a\": 1e999}") == "x.json: line 1, column 11: number overflow parsing '1e999'");
}

TEST_CASE("Text that is not UTF-8 is refused") {
  CHECK(parse_refusal("{\"a\": \"\xff\"}").find("ill-formed UTF-8 byte") != std::string::npos);
  CHECK(parse_refusal("{\"a\": \"\xc3\"}").find("ill-formed UTF-8 byte") != std::string::npos);
  CHECK(parse_refusal("{\"a\": \"\xed\xa0\x80\"}").find("ill-formed UTF-8 byte") != std::string::npos);  // surrogate
  CHECK(parse_refusal("{\"a\": \"\xc0\x80\"}").find("ill-formed UTF-8 byte") != std::string::npos);      // overlong
}

TEST_CASE("A key may be given once") {
  CHECK(parse_refusal(R"({"a": {"port": 1, "other": 2, "port": 3}})") == "x.json: /a/port: given twice");
  CHECK(parse_refusal(R"([{}, {"p": 1, "p": 1}])") == "x.json: /1/p: given twice");
  CHECK(parse_refusal(R"({"a": [[0, 1], [{"p": [], "p": 1}]]})") == "x.json: /a/1/0/p: given twice");
  CHECK_NOTHROW(parse_json(R"({"a": {"p": 1}, "b": {"p": 1}})", "x.json"));
}

TEST_CASE("Nesting, strings and the whole text are bounded") {
  const auto nested = [](std::size_t depth) { return std::string(depth, '[') + std::string(depth, ']'); };
  CHECK_NOTHROW(parse_json(nested(kMaxJsonDepth), "x.json"));
  CHECK(parse_refusal(nested(kMaxJsonDepth + 1)).find("nested deeper than 16 levels") != std::string::npos);
  CHECK(parse_refusal(nested(400000)).find("nested deeper than 16 levels") != std::string::npos);

  const auto text_of = [](std::size_t bytes) { return std::string("[\"").append(bytes, 'a') + "\"]"; };
  CHECK_NOTHROW(parse_json(text_of(kMaxJsonString), "x.json"));
  CHECK(parse_refusal(text_of(kMaxJsonString + 1)) ==
        "x.json: /0: a string of 1025 bytes is longer than the maximum 1024");

  CHECK(parse_refusal(R"(["", "a\u0000b"])") == "x.json: /1: a string holds the character U+0000");

  const std::string padding(kMaxJsonBytes - 2, ' ');
  CHECK_NOTHROW(parse_json("[]" + padding, "x.json"));
  CHECK(parse_refusal("[] " + padding) == "x.json: larger than the maximum of 1048576 bytes");
}

TEST_CASE("A hundred thousand keys are read in a moment") {
  std::string text = "{";
  for (int i = 0; i < 100000; ++i) text += (i ? ",\"" : "\"") + std::to_string(i) + "\":0";
  CHECK(parse_json(text + "}", "x.json").size() == 100000);
}

TEST_CASE("Files that cannot be read are refused by name") {
  const BundleFolder folder;
  const auto path = folder.path() / "absent.json";
  CHECK(refusal([&] { read_json(path); }) == path.string() + ": no such file");
  CHECK(refusal([&] { read_json(folder.path()); }) == folder.path().string() + ": not a regular file");
  const auto huge = folder.write("huge.json", std::string(kMaxJsonBytes + 1, ' '));
  CHECK(refusal([&] { read_json(huge); }) == huge.string() + ": larger than the maximum of 1048576 bytes");
}

TEST_CASE("Every truncation of a document is refused in one line") {
  const std::string text = kFullBundle;
  for (std::size_t size = 0; size < text.size(); ++size) {
    const std::string line = parse_refusal(text.substr(0, size));
    CAPTURE(size, line);
    REQUIRE(line.rfind("x.json: line ", 0) == 0);
    REQUIRE(line.find('\n') == std::string::npos);
    REQUIRE(line.size() < 300);
  }
}

TEST_CASE("Values in messages are clipped and printable") {
  CHECK(quoted(Json(std::string(100, 'a'))) == std::string("\"").append(59, 'a') + "...");
  CHECK(quoted(Json("a\nb\xc3\xbc")) == "\"a\\nb??\"");
  CHECK(quoted(Json("\xff")).find('\xff') == std::string::npos);
}
