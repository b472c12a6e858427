#include "program.h"
#include "shared_data.h"

#include <algorithm>

namespace
{

const char* const pipeline = R"(version: 1
vars: {start: 4, stop: 5}
stages:
  source: {type: test.source, value: "${start}"}
  add: {type: test.add, input: {left: source}, plus: 1}
  odd: {type: test.nothing}
)";

/// Offered at the last of the words.
std::vector<std::string> offered(Workplace& place, std::vector<std::string> words)
{
    std::vector<std::string> arguments{"internal-complete", std::to_string(words.size()), "--", "fresco"};
    arguments.insert(arguments.end(), words.begin(), words.end());
    const auto finished = place.run(arguments);
    CHECK(finished.code == 0);
    CHECK(finished.err.empty());
    std::istringstream lines(finished.out);
    std::vector<std::string> result;
    for (std::string line; std::getline(lines, line);)
        result.push_back(line);
    return result;
}

bool has(const std::vector<std::string>& all, const std::string& word)
{
    return std::find(all.begin(), all.end(), word) != all.end();
}

using Words = std::vector<std::string>;

}  // namespace

TEST_CASE("commands, options and types are offered from the program and the registry")
{
    Workplace place;
    const auto commands = offered(place, {""});
    for (const char* name : {"run", "plan", "check", "new", "init", "store", "describe", "completion", "doctor"})
        CHECK(has(commands, name));
    CHECK_FALSE(has(commands, "internal-run"));
    CHECK(offered(place, {"des"}) == Words{"describe"});
    CHECK(offered(place, {"store", "v"}) == Words{"verify"});
    CHECK(has(offered(place, {"run", "--"}), "--set"));
    CHECK(has(offered(place, {"run", "room.yaml", "--j"}), "--json-log"));
    CHECK_FALSE(has(offered(place, {"check", "--"}), "--cores"));
    CHECK(has(offered(place, {"describe", "test.a"}), "test.add"));
    CHECK_FALSE(has(offered(place, {"describe", "test.a"}), "test.source"));
    CHECK(offered(place, {"new", ""}) == Words{"features", "loss", "reader", "stage", "texture"});
    CHECK(offered(place, {"new", "loss", ""}).empty());
    CHECK(offered(place, {"completion", "z"}) == Words{"zsh"});
    CHECK(offered(place, {"run", ""}) == Words{":files"});
    CHECK(offered(place, {"log", ""}) == Words{":files"});
    CHECK(offered(place, {"init", ""}) == Words{":folders"});
    CHECK(offered(place, {"run", "room.yaml", "--out", ""}) == Words{":folders"});
    CHECK(offered(place, {"run", "room.yaml", "--cores", ""}).empty());
    CHECK(offered(place, {"nothing", "at", "all"}).empty());
}

TEST_CASE("--set offers what the pipeline has, and --until its stages")
{
    Workplace place;
    place.write("room.yaml", pipeline);
    CHECK(offered(place, {"run", "room.yaml", "--set", "st"}) == Words{"start=", "stop="});
    place.write("hostile.yaml", "version: 1\nvars: {good: 1, \"$(touch gone)\": 1, \"a\\nb\": 1, \"a;b\": 1}\n");
    CHECK(offered(place, {"run", "hostile.yaml", "--set", ""}) == Words{"good="});
    CHECK(has(offered(place, {"run", "room.yaml", "--set", "add."}), "add.plus="));
    CHECK(offered(place, {"run", "room.yaml", "--set", "add.pl"}) == Words{"add.plus="});
    // A setting before, in one word or as a shell cuts it.
    CHECK(offered(place, {"run", "--set", "start=3", "room.yaml", "--set", "add.pl"}) == Words{"add.plus="});
    CHECK(offered(place, {"run", "room.yaml", "--set", "start", "=", "3", "--until", "s"}) == Words{"source"});
    CHECK(offered(place, {"plan", "room.yaml", "--until", ""}) == Words{"add", "odd", "source"});
    CHECK(offered(place, {"log", "room.yaml", ""}) == Words{"add", "odd", "source"});
    // In one word with the option, whole (zsh) or cut (bash).
    CHECK(offered(place, {"plan", "room.yaml", "--until=so"}) == Words{"source"});
    CHECK(offered(place, {"plan", "room.yaml", "--until", "=", "so"}) == Words{"source"});
    CHECK(offered(place, {"plan", "room.yaml", "--until", "="}) == Words{"add", "odd", "source"});
    CHECK(offered(place, {"run", "room.yaml", "--out=a"}) == Words{":folders"});
    CHECK(offered(place, {"run", "room.yaml", "--out", "=", "a"}) == Words{":folders"});
    CHECK(offered(place, {"run", "room.yaml", "--out", "=", "a", "--until", "s"}) == Words{"source"});
    CHECK(offered(place, {"run", "room.yaml", "--nothing=a"}).empty());
    // A value may be a file.
    CHECK(offered(place, {"run", "room.yaml", "--set", "start=a"}) == Words{":files"});
    CHECK(offered(place, {"run", "room.yaml", "--set", "start", "=", "a"}) == Words{":files"});
    CHECK(offered(place, {"run", "room.yaml", "--set", "start", "="}) == Words{":files"});
    CHECK(offered(place, {"run", "missing.yaml", "--set", ""}).empty());
    CHECK(offered(place, {"run", "--set", ""}).empty());
    place.write("bad.yaml", "version: [1\nstages: {a");
    CHECK(offered(place, {"run", "bad.yaml", "--set", ""}).empty());
}

TEST_CASE("bash completes by the script")
{
    Workplace place;
    place.write("room.yaml", pipeline);
    place.write("a folder/x", "");
    const auto script = place.run({"completion", "bash"});
    REQUIRE(script.code == 0);
    place.write("script.sh", script.out);
    const auto completed = [&](const std::string& words)
    {
        const std::string command = "cd '" + place.work().string() + "'; source script.sh; COMP_WORDS=(" + words +
                                    "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); compopt() { echo \"$@\" >>options; }; _fresco; "
                                    "printf '%s\\n' \"${COMPREPLY[@]}\" >answer";
        fs::remove(place.file("options"));
        std::string environment;
        for (const auto& [name, value] : place.environment)
            environment += name + "='" + value + "' ";
        place.write("go.sh", command);
        REQUIRE(std::system((environment + "bash '" + place.file("go.sh").string() + "'").c_str()) == 0);
        return place.read("answer");
    };
    const std::string program = "'" + (place.root() / "bin" / "fresco").string() + "'";
    CHECK(completed(program + " des") == "describe\n");
    CHECK(completed(program + " run room.yaml --set add.pl") == "add.plus=\n");
    CHECK(place.read("options") == "-o nospace\n");
    CHECK(completed(program + " run roo") == "room.yaml\n");
    CHECK(completed(program + " init a") == "a folder\n");
    CHECK(place.read("options") == "-o filenames\n");
    CHECK(completed(program + " run room.yaml --out =") == "a folder\n");
    CHECK(place.run({"completion", "zsh"}).out.starts_with("#compdef fresco\n"));
    CHECK(place.run({"completion", "tcsh"}).code == 2);
}

TEST_CASE("fish completes by the script")
{
    Workplace place;
    place.write("room.yaml", pipeline);
    place.write("a folder/x", "");
    const auto script = place.run({"completion", "fish"});
    REQUIRE(script.code == 0);
    place.write("script.fish", script.out);
    if (std::system("command -v fish >/dev/null") != 0)
    {
        skipped("completion by fish: fish is not installed");
        return;
    }
    const auto completed = [&](const std::string& line)
    {
        std::string environment = "PATH='" + (place.root() / "bin").string() + "':$PATH ";
        for (const auto& [name, value] : place.environment)
            environment += name + "='" + value + "' ";
        const std::string commands = "source script.fish; complete --do-complete='" + line + "' >answer";
        place.write("go.sh",
                    "cd '" + place.work().string() + "'; " + environment + "fish --no-config --command \"" + commands + "\"");
        REQUIRE(std::system(("sh '" + place.file("go.sh").string() + "'").c_str()) == 0);
        return place.read("answer");
    };
    CHECK(completed("fresco des") == "describe\n");
    CHECK(completed("fresco run room.yaml --set add.pl") == "add.plus=\n");
    CHECK(completed("fresco run roo") == "room.yaml\n");
    CHECK(completed("fresco run room.yaml --set=add.pl") == "--set=add.plus=\n");
    CHECK(completed("fresco run room.yaml --out=a").starts_with("--out=a folder/"));
}

TEST_CASE("The manual has the commands and options of --help")
{
    Workplace place;
    const std::string manual = place.run({"internal-manual"}).out;
    CHECK(manual.starts_with(".TH FRESCO 1 "));
    for (const auto& command : offered(place, {""}))
    {
        CAPTURE(command);
        CHECK((contains(manual, ".SS fresco " + command + "\n") || contains(manual, ".SS fresco " + command + " ")));
        for (std::string option : offered(place, {command, "--"}))
        {
            CAPTURE(option);
            for (std::size_t at = 0; (at = option.find('-', at)) != std::string::npos; at += 2)
                option.insert(at, "\\");
            CHECK(contains(manual, option));
        }
    }
    CHECK(contains(manual, "\\fB\\-\\-cores"));
    CHECK(contains(manual, ".SH EXIT STATUS\nExit codes: 0 done"));
}
