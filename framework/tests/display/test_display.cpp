#include "base/text.h"
#include "display/display.h"
#include "display/run_view.h"
#include "terminal.h"

#include <regex>

using namespace fresco::host;
using Kind = TextTable::Kind;

namespace
{

ViewStage stage(const std::string& name, StageState state, double seconds = 0, double expected_s = 0)
{
    ViewStage result;
    result.name = name;
    result.state = state;
    result.seconds = seconds;
    result.expected_s = expected_s;
    return result;
}

/// Half of a run: the fourth stage counts.
std::vector<ViewStage> half_way()
{
    std::vector<ViewStage> stages{stage("scan", StageState::stored),          stage("mesh", StageState::done, 12.3),
                                  stage("bad", StageState::failed, 2),        stage("texture", StageState::running, 60, 200),
                                  stage("bake", StageState::waiting, 0, 0.7), stage("behind", StageState::blocked)};
    ViewStage& texture = stages[3];
    texture.threads = 2;
    texture.done = 100;
    texture.total = 400;
    texture.unit = "steps";
    texture.rate = 2;
    texture.metrics = {{"loss", 0.25}, {"rate", std::nullopt}};
    texture.preview = "out/progress/texture/texture.png";
    return stages;
}

ViewFrame frame_of(std::size_t width, std::size_t height, bool utf8 = true)
{
    return {.width = width, .height = height, .utf8 = utf8, .cores = 2, .seconds = 75};
}

const char* const long_names = R"(version: 1
vars: {value: 3}
matrix: {value: {first: 3, second: 4}}
stages:
  a_source_with_a_long_name: {type: test.source, value: "${value}"}
  slow: {type: test.slow, input: a_source_with_a_long_name, steps: 4, step_ms: 50}
  text: {type: test.sink, input: slow, path: x.txt}
)";

/// Lines that were ever written, without what moves the cursor.
Words written_lines(const std::string& written)
{
    return lines_of(std::regex_replace(written, std::regex("\x1b\\[[0-9]*[A-Za-z]|\r"), ""));
}

/// A word wider than the terminal gets a line of its own.
bool fits(const std::string& line, std::size_t width)
{
    const std::size_t first = line.find_first_not_of(' ');
    return columns(line) <= width || line.find(' ', first) == std::string::npos;
}

}  // namespace

TEST_CASE("the view of a run: every stage, what the running one counts, its loss and picture, the whole")
{
    CHECK(draw_view(half_way(), frame_of(100, 24)) ==
          Words{" = scan    stored", " ✓ mesh    12 s", " ✗ bad     failed after 2.0 s",
                " ● texture ━━━━━┈┈┈┈┈┈┈┈┈┈┈┈┈┈┈ 100 of 400 steps · 2:23 min left · 2 steps/s",
                "           loss 0.25 · rate not finite · out/progress/texture/texture.png", " · bake    ~0.7 s",
                " - behind  not run", "2 of 6 done · 1 failed · 1:15 min · about 2:23 min left"});
    const Words ascii = draw_view(half_way(), frame_of(80, 24, false));
    CHECK(ascii[1] == " + mesh    12 s");
    CHECK(ascii[3] == " > texture ####------------ 100 of 400 steps, 2:23 min left, 2 steps/s");
    CHECK(ascii[4] == "           loss 0.25, rate not finite, out/progress/texture/texture.png");
}

TEST_CASE("a small terminal shows what fits: shorter lines, then no details, then what matters most")
{
    const Words narrow = draw_view(half_way(), frame_of(40, 10));
    CHECK(narrow[3] == " ● texture ━━┈┈┈┈┈┈ 25 % · 2:23 min le…");
    CHECK(narrow.back() == "2 of 6 done · 1 failed · 1:15 min · ab…");
    CHECK(draw_view(half_way(), frame_of(40, 8)).size() == 7);
    CHECK(draw_view(half_way(), frame_of(60, 7)) ==
          Words{" ✓ 2 more done", " ✗ bad     failed after 2.0 s", " ● texture ━━━┈┈┈┈┈┈┈┈┈ 100 of 400 steps · 2:23 min left ·…",
                " · bake    ~0.7 s", " · 1 more to do", "2 of 6 done · 1 failed · 1:15 min · about 2:23 min left"});
    std::vector<ViewStage> many = half_way();
    for (int i = 0; i < 300; ++i)
        many.push_back(stage("stage_with_a_long_name_" + std::to_string(i) + "@küche,東京", StageState::waiting, 0, 1));
    for (std::size_t width = 1; width < 120; ++width)
        for (std::size_t height = 1; height < 14; ++height)
        {
            const Words lines = draw_view(many, frame_of(width, height, width % 2 == 0));
            REQUIRE(lines.size() < height);
            for (const std::string& line : lines)
                REQUIRE(columns(line) < std::max<std::size_t>(width, 1));
        }
    // A short count names the one that is being worked on.
    CHECK(Count{2, 10, "rounds", 0, {}}.count_text() == "round 3 of 10");
    CHECK(Count{10, 10, "rounds", 0, {}}.count_text() == "10 of 10 rounds");
    CHECK(Count{2, 21, "rounds", 0, {}}.count_text() == "2 of 21 rounds");
    CHECK(Count{2, 0, "frames", 0, {}}.count_text() == "2 frames");
    CHECK(draw_view({}, frame_of(80, 24)) == Words{"0 of 0 done · 1:15 min"});
}

TEST_CASE("colors take no room, and a cut line ends in plain")
{
    ViewFrame frame = frame_of(30, 24);
    const Words plain = draw_view(half_way(), frame);
    frame.color = true;
    const Words colored = draw_view(half_way(), frame);
    REQUIRE(plain.size() == colored.size());
    for (std::size_t i = 0; i < plain.size(); ++i)
        CHECK(columns(plain[i]) == columns(colored[i]));
    CHECK(colored[2].find("\x1b[31m✗\x1b[0m") != std::string::npos);
    CHECK(columns("\x1b[31m東京\x1b[0m é") == 6);
    CHECK(Line({5, true, false}).add("abc\x1b[31mdef").take() == "abc …");
    CHECK(Line({5, false, false}).add("abcdefg").take() == "abcd~");
    CHECK(Line({5, true, false}).add("東京都").take() == "東京…");
    CHECK(Line({9, true, false}).add("a\x01 \xc2\x9b c").take() == "a    c");
}

TEST_CASE("a name can neither move the cursor, nor turn the line around, nor begin a line of fresco's own")
{
    CHECK(harmless("é 東\nb\r\x1b[2J\xc2\x9b\t\x7f\xff", LineEnds::all) == "é 東\nb\\x0d\\x1b[2J\\x9b \\x7f\\xff");
    // U+200D joins emoji and stays.
    CHECK(harmless("\u202e, \u2066, \u2028, \u200f, \u200d", LineEnds::none) == "\\u202e, \\u2066, \\u2028, \\u200f, \u200d");
    const std::string name = "no file\nerror: all is lost";
    CHECK(harmless("error: " + name + ".png: is missing\n    | it printed this", LineEnds::continued) ==
          "error: no file\\nerror: all is lost.png: is missing\n    | it printed this");
    CHECK(harmless(name + "\n", LineEnds::none) == "no file\\nerror: all is lost\\n");
    TextTable table({{"", Kind::figure}});
    table.add({name});
    CHECK(table.text(without_end) == "no file\\nerror: all is lost\n");
}

TEST_CASE("what is left: the count's speed, trusted as far as it has come, and what was learned")
{
    ViewStage texture = half_way()[3];
    // A quarter done: 300 steps at 2 steps/s, and 140 s of the 200 that it took before.
    CHECK(left_s(texture) == 0.25 * 150 + 0.75 * 140);
    texture.seconds = 230;
    CHECK(left_s(texture) == 150.0);
    texture.rate = 0;
    CHECK_FALSE(left_s(texture));
    texture.seconds = 50;
    CHECK(left_s(texture) == 150.0);
    CHECK(left_s(stage("w", StageState::waiting, 0, 7)) == 7.0);
    CHECK_FALSE(left_s(stage("w", StageState::waiting)));
    CHECK_FALSE(left_s(stage("w", StageState::stored, 0, 7)));
    // Two side by side on a core each, and one to come; never less than the longest.
    ViewStage other = texture;
    texture.threads = other.threads = 1;
    CHECK(left_s({texture, other, stage("w", StageState::waiting, 0, 7)}, 2) == 157.0);
    CHECK(left_s({texture}, 8) == 150.0);
    CHECK_FALSE(left_s({stage("a", StageState::done, 3, 4)}, 2));
}

TEST_CASE("on a terminal the view is redrawn in place and leaves only what the run came to")
{
    RoomPlace place(R"(
  source: {type: test.source, value: 3}
  slow:   {type: test.slow, input: source, steps: 40, step_ms: 60, log: log}
  bad:    {type: test.fail, input: slow, how: error}
  text:   {type: test.sink, input: slow, path: x.txt}
)");
    Terminal terminal(place, {"run", "room.yaml"}, 70, 20);
    REQUIRE(terminal.shows(" of 40 steps"));
    CHECK(std::regex_search(terminal.text(), std::regex(R"(\n \+ source .*\n > slow .*\n( .*\n)+1 of 4 done, .*\n+$)")));
    CHECK(terminal.shows("loss 0."));
    // Narrower, with lines that the terminal breaks: no pieces of the old view remain.
    terminal.resize(40, 10);
    REQUIRE(terminal.shows("source"));
    CHECK(terminal.finish() == 1);
    const std::string text = terminal.text();
    INFO(text);
    for (const char* part : {"source: made 3.000000", "mesh.ply:7: three\n", "text    ran", "out/x.txt"})
        CHECK(contains(text, part));
    for (const char* part : {" > slow", " done, "})
        CHECK(text.find(part) == std::string::npos);
    // The terminal's modes are not changed.
    CHECK(terminal.written().find("\x1b[?") == std::string::npos);
}

TEST_CASE("Ctrl-C on a terminal ends the view and the run in order")
{
    RoomPlace place("\n  slow: {type: test.slow, steps: 1000, log: log}\n");
    Terminal terminal(place, {"run", "room.yaml"}, 60, 12);
    REQUIRE(terminal.shows(" of 1000 steps"));
    terminal.type("\x03");
    CHECK(terminal.finish() == 75);
    CHECK(contains(terminal.text(), "stopping; press Ctrl-C again"));
    CHECK(contains(terminal.text(), "slow   interrupted"));
    CHECK(terminal.text().find(" > slow") == std::string::npos);
}

TEST_CASE("in the background a run leaves the terminal to the shell")
{
    RoomPlace place("\n  source: {type: test.source, value: 3}\n"
                    "  slow: {type: test.slow, input: source, steps: 5, step_ms: 60, log: log}\n");
    Terminal terminal(place, {"run", "room.yaml"}, 70, 20, true);
    CHECK(terminal.finish() == 0);
    CHECK(contains(terminal.text(), "source: made 3.000000"));
    CHECK(contains(terminal.text(), "slow    ran"));
    CHECK(terminal.written().find("A\r") == std::string::npos);
    CHECK(terminal.written().find("\x1b[J") == std::string::npos);
}

TEST_CASE("Lines are broken at blanks and go on with an indent, words stay whole")
{
    CHECK(folded("one two three four", 9, 2) == "one two\n  three\n  four");
    CHECK(folded("  one two three", 9, 2) == "  one two\n    three");
    CHECK(folded("a/path/that/is/longer/than/this and more", 10) == "a/path/that/is/longer/than/this\nand more");
    CHECK(folded("one two\nthree four five\n", 10) == "one two\nthree four\nfive\n");
    CHECK(folded("a    b   c", 8) == "a    b\nc");
    CHECK(folded("größer größer", 6) == "größer\ngrößer");
}

TEST_CASE("A table gives way to a narrow terminal step by step")
{
    TextTable table({{"stage", Kind::figure}, {"time", Kind::number}, {"why", Kind::text}});
    table.add({"texture@kitchen,waves", "1.0 s", "the option size_px was changed from 2048 to 1024"});
    table.add({"glb", "12.0 s", ""});
    CHECK(table.text(without_end) == "stage                    time  why\n"
                                     "texture@kitchen,waves   1.0 s  the option size_px was changed from 2048 to 1024\n"
                                     "glb                    12.0 s\n");
    CHECK(table.text(60) == "stage                    time  why\n"
                            "texture@kitchen,waves   1.0 s  the option size_px was\n"
                            "                               changed from 2048 to 1024\n"
                            "glb                    12.0 s\n");
    for (unsigned width = 30; width < 100; ++width)
        for (const std::string& line : lines_of(table.text(width)))
            CHECK(fits(line, width));
    CHECK(contains(table.text(40), "texture@kitchen,waves   1.0 s\n    the option size_px was changed from\n"));
}

TEST_CASE("At 60 columns no line is wider, and no word is split; a file gets whole lines without colors, or those of COLUMNS")
{
    RoomPlace place(long_names);
    place.write("one.yaml", "version: 1\nstages:\n  slow: {type: test.slow, steps: 4, step_ms: 50}\n"
                            "  bad: {type: test.fail, input: slow, how: error}\n");
    place.write("wrong.yaml",
                "version: 1\nstages:\n  slow: {type: test.slow, steps: many, stepms: 3}\n  two: {type: test.nothin}\n");
    const Words commands{"plan room.yaml",
                         "run room.yaml",
                         "run one.yaml",
                         "check wrong.yaml",
                         "stages",
                         "describe test.add",
                         "describe read.number",
                         "log room.yaml slow@first",
                         "doctor",
                         "--help",
                         "run --help",
                         "store gc --help",
                         "run room.yaml --nothing that it has for an argument of this name",
                         "new stage my.dots"};
    constexpr unsigned short width = 60;
    for (const std::string& command : commands)
    {
        Terminal terminal(place, split(command, ' '), width, 24);
        terminal.finish();
        const Words lines = written_lines(terminal.written());
        CAPTURE(command, terminal.text());
        CHECK_FALSE(lines.empty());
        for (const std::string& line : lines)
            if (!fits(line, width) && !line.starts_with("  cmake ") &&
                !line.starts_with("  FRESCO_PLUGIN_PATH="))  // To be copied.
                FAIL_CHECK(line);
    }

    const std::string plan = place.run({"plan", "room.yaml", "--store", "other"}).out;
    CHECK(contains(plan, "a_source_with_a_long_name@second  run"));
    const std::string run = place.make({"--store", "other"}).err;
    CHECK((contains(run, ": done in ") && run.find('\x1b') == std::string::npos));
    place.environment["COLUMNS"] = "60";
    for (const std::string& line : lines_of(place.run({"plan", "room.yaml"}).out))
        CHECK(fits(line, width));
}
