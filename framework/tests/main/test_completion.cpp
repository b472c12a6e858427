#include "program.h"
#include "shared_data.h"

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
Words offered(Workplace& place, Words words)
{
    words.insert(words.begin(), {"internal-complete", std::to_string(words.size()), "--", "fresco"});
    const Finished finished = place.run(words, 0);
    CHECK(finished.err.empty());
    return lines_of(finished.out);
}

bool has(const Words& all, const std::string& word)
{
    return std::ranges::count(all, word) > 0;
}

}  // namespace

TEST_CASE("commands, options and types are offered from the program and the registry, and what the pipeline has")
{
    Workplace place;
    place.write("room.yaml", pipeline);
    place.write("hostile.yaml", "version: 1\nvars: {good: 1, \"$(touch gone)\": 1, \"a\\nb\": 1, \"a;b\": 1}\n");
    place.write("bad.yaml", "version: [1\nstages: {a");
    const Words commands = offered(place, {""});
    CHECK((has(commands, "run") && has(commands, "store") && !has(commands, "internal-run")));
    CHECK(has(offered(place, {"run", "--"}), "--set"));
    CHECK_FALSE(has(offered(place, {"check", "--"}), "--cores"));
    CHECK(has(offered(place, {"describe", "test.a"}), "test.add"));
    CHECK(has(offered(place, {"run", "room.yaml", "--set", "add."}), "add.plus="));
    CHECK(has(offered(place, {"run", "room.yaml", "--set", "comp"}), "components.scaler="));
    const Words files{":files"};
    const Words folders{":folders"};
    for (const auto& [words, expected] :
         std::vector<std::pair<Words, Words>>{{{"des"}, {"describe"}},
                                              {{"store", "v"}, {"verify"}},
                                              {{"run", "room.yaml", "--j"}, {"--jobs", "--json-log"}},
                                              {{"new", ""}, {"features", "layout", "loss", "stage", "texture"}},
                                              {{"run", ""}, files},
                                              {{"init", ""}, folders},
                                              {{"run", "room.yaml", "--out", ""}, folders},
                                              {{"run", "room.yaml", "--cores", ""}, {}},
                                              {{"run", "room.yaml", "--set", "st"}, {"start=", "stop="}},
                                              {{"run", "hostile.yaml", "--set", ""}, {"good="}},
                                              // A setting before, in one word or as a shell cuts it.
                                              {{"run", "--set", "start=3", "room.yaml", "--set", "add.pl"}, {"add.plus="}},
                                              {{"run", "room.yaml", "--set", "start", "=", "3", "--until", "s"}, {"source"}},
                                              {{"check", "room.yaml", "--without", "o"}, {"odd"}},
                                              {{"log", "room.yaml", ""}, {"add", "odd", "source"}},
                                              // In one word with the option, whole (zsh) or cut (bash).
                                              {{"plan", "room.yaml", "--until", "=", "so"}, {"source"}},
                                              {{"plan", "room.yaml", "--until", "="}, {"add", "odd", "source"}},
                                              {{"run", "room.yaml", "--out=a"}, folders},
                                              {{"run", "room.yaml", "--out", "=", "a"}, folders},
                                              // A value may be a file.
                                              {{"run", "room.yaml", "--set", "start=a"}, files},
                                              {{"run", "room.yaml", "--set", "start", "=", "a"}, files},
                                              {{"run", "bad.yaml", "--set", ""}, {}}})
    {
        CAPTURE(words);
        CHECK(offered(place, words) == expected);
    }
}

TEST_CASE("bash and fish complete by their scripts")
{
    Workplace place;
    place.write("room.yaml", pipeline);
    place.write("a folder/x", "");
    for (const char* shell : {"bash", "fish"})
        place.write(std::string("script.") + shell, place.run({"completion", shell}).out);
    CHECK(place.run({"completion", "zsh"}).out.starts_with("#compdef fresco\n"));
    const auto in_bash = [&](const std::string& words)
    {
        return place
            .in_shell("source script.bash; COMP_WORDS=($F " + words +
                      "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); compopt() { echo \"$@\"; }; _fresco; echo \"${COMPREPLY[@]}\"")
            .out;
    };
    CHECK(in_bash("des") == "describe\n");
    CHECK(in_bash("run room.yaml --set add.pl") == "-o nospace\nadd.plus=\n");
    CHECK(in_bash("init a") == "-o filenames\na folder\n");
    CHECK(in_bash("run room.yaml --out =") == "-o filenames\na folder\n");
    if (std::system("command -v fish >/dev/null") != 0)
        return skipped("completion by fish: fish is not installed");
    const auto in_fish = [&](const std::string& line)
    {
        return place
            .in_shell("PATH=$(dirname $F):$PATH fish --no-config --command \"source script.fish; complete --do-complete='" +
                      line + "'\"")
            .out;
    };
    CHECK(in_fish("fresco run room.yaml --set add.pl") == "add.plus=\n");
    CHECK(in_fish("fresco run room.yaml --set=add.pl") == "--set=add.plus=\n");
    CHECK(in_fish("fresco run room.yaml --out=a").starts_with("--out=a folder/"));
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
    CHECK(contains(manual, ".SH EXIT STATUS\nExit codes: 0 done"));
}
