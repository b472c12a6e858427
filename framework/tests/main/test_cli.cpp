#include "base/text.h"
#include "program.h"

using fresco::host::split;

namespace
{

/// Output of `fresco plan room.yaml` with more words.
std::string plan_text(Workplace& place, Words more = {})
{
    more.insert(more.begin(), {"plan", "room.yaml"});
    return place.run(more, 0).out;
}

fresco::Value planned(Workplace& place, Words more = {})
{
    more.emplace_back("--json");
    return fresco::parse_json(plan_text(place, more));
}

std::string reason(const fresco::Value& plan, const std::string& stage)
{
    for (const auto& entry : plan.at("stages").as_list())
        if (entry.at("stage").as_string() == stage)
            return (entry.at("runs").as_bool() ? "run: " : "rest: ") + entry.at("reason").as_string();
    return "";
}

}  // namespace

TEST_CASE("plan says what would run and why")
{
    RoomPlace place;
    auto plan = planned(place);
    CHECK(reason(plan, "source") == "run: not stored yet");
    CHECK(reason(plan, "add") == "run: runs after source");
    CHECK(plan.at("total").at("not_run_yet").as_int() == 3);
    CHECK(plan_text(place).ends_with("3 stages have not run yet\n"));
    CHECK(place.log().empty());
    place.make();
    CHECK(reason(planned(place), "source") == "rest: stored");
    CHECK(contains(plan_text(place), "nothing to do"));
    // Elsewhere its files are missing.
    CHECK(plan_text(place, {"--out", "elsewhere"}).ends_with("copies 1 file of text to elsewhere\n"));
    CHECK_FALSE(fs::exists(place.file("elsewhere")));
    place.write("out/x.txt", "changed");
    CHECK(contains(plan_text(place), "a run would stop: "));
    CHECK(contains(plan_text(place), "out/x.txt: changed since fresco wrote it; choose another folder with --out"));
    place.run({"run", "room.yaml"}, 1);
    place.make({"--replace"});
    CHECK(contains(reason(planned(place, {"--set", "add.plus=5"}), "add"), "run: option plus was 1"));
    plan = planned(place, {"--set", "start=9"});
    CHECK(contains(reason(plan, "source"), "option value was 4"));
    CHECK(plan.at("stages").as_list().at(0).at("seconds").as_double() > 0);
    CHECK(plan.at("total").at("memory_mb").as_double() > 1);
    CHECK(contains(plan_text(place, {"--set", "start=9"}), " of memory at a time per stage\n"));
    fs::remove_all(place.file(".fresco/objects"));
    CHECK(contains(reason(planned(place), "source"), "removed from the store"));
}

TEST_CASE("Exit codes; a command line that is refused gets the nearest name, and where help is; without a command it is the help")
{
    RoomPlace place;
    place.write("bad.yaml", "version: 1\nstages:\n  source: {type: test.source, valu: 3}\n");
    place.write("missing.yaml", "version: 1\nstages:\n  source: {type: test.source, file: nowhere.bin}\n");
    place.write("notastore", "text");
    const std::string until = "--until sorce: error: unknown stage 'sorce' (did you mean 'source'?)";
    for (const auto& [code, commands, problem] : std::vector<std::tuple<int, Words, std::string>>{
             {0,
              {"run room.yaml --quiet", "check room.yaml", "--help", "version", "stages --json", "describe test.source",
               "doctor"},
              ""},
             {2,
              {"check bad.yaml", "run room.yaml --cores 0", "run room.yaml --set nonsense", "run room.yaml --out ",
               "run room.yaml --store notastore", "describe test.sorce"},
              ""},
             {3, {"plan missing.yaml", "run nowhere.yaml"}, ""},
             {2, {"run room.yaml --until sorce", "plan room.yaml --until sorce"}, until},
             {2, {"run"}, "error: pipeline is required\n    fresco run --help lists what it accepts\n"},
             {2, {"run --prevew=1 room.yaml"}, "error: unknown option '--prevew=1' (did you mean '--preview'?)\n"},
             {2, {"store verfy"}, "unknown command 'verfy' (did you mean 'verify'?)\n"},
             {2, {"plan room.yaml more"}, "more\n    fresco plan --help"},
             {2, {"run room.yaml --stage-time soon"}, "--stage-time: soon unit not recognized. Allowed values: {h,m,s}"},
             {2, {"run room.yaml --stage-time 0.001m"}, "--stage-time: Value 0.06 not in range"},
             {2, {"run room.yaml --stage-time 500000h"}, "--stage-time: Value 1.8e+09 not in range"},
             {2, {"run room.yaml --stage-memory 4"}, "--stage-memory: Value 4 not in range"},
             {2, {"run room.yaml --stage-memory 0.01G"}, "--stage-memory: Value 10.24 not in range"},
             {2, {"run room.yaml --jobs 2"}, "--jobs: error: only for pipelines with a 'matrix'"},
             {2, {"run room.yaml --keep-going"}, "--keep-going: error: "},
             {3, {"store ls --store nowhere", "store verify --store nowhere", "store gc --store nowhere"}, "not a store"}})
        for (const std::string& command : commands)
        {
            CAPTURE(command);
            const Finished finished = place.run(split(command, ' '));
            CHECK(finished.code == code);
            CHECK(contains(finished.err, problem));
        }
    CHECK(place.logged("source") == 1);
    CHECK(!fs::exists(place.file("nowhere")));
    CHECK(place.run({}, 2).out.starts_with("fresco paints"));
    CHECK(contains(place.run({"store"}, 2).out, "Usage: fresco store"));
    // No library is taken from the folder that the program is run in.
    place.write("libstdc++.so.6", "no library");
    CHECK(place.run({"version"}).err.empty());
}

TEST_CASE("A preview has its own options and its own folder")
{
    Workplace place;
    place.write("room.yaml", chain + "preview: {add: {plus: 2}}\n");
    place.make();
    const std::string full = place.read("out/x.txt");
    CHECK(contains(reason(planned(place, {"--preview"}), "add"), "run: option plus was 1"));
    place.make({"--preview"});
    CHECK(place.read("out/x.txt") == full);
    CHECK(place.read("out/preview/x.txt") != full);
    CHECK(plan_text(place, {"--preview", "--out", "small"}).ends_with("copies 1 file of text to small\n"));
    place.write("out/preview/x.txt", "changed");
    CHECK(contains(plan_text(place, {"--preview"}), "copies 1 file of text to out/preview\n"));
    fs::remove(place.file("out/preview/x.txt"));

    place.run({"run", "room.yaml", "--preview", "--set", "start=7", "--task", "once"}, 0);
    CHECK(contains(plan_text(place, {"--preview", "--set", "start=7"}), "nothing to do"));
}

TEST_CASE("Output that cannot be written is an error, but a reader may go away")
{
    RoomPlace place;
    const Finished full = place.in_shell("$F schema --json > /dev/full");
    CHECK(full.code == 1);
    CHECK(contains(full.err, "standard output could not be written"));
    CHECK(place.in_shell("{ $F schema --json; echo $? >&2; } | true").err == "0\n");
    // Files of the store do not become the closed standard output.
    CHECK(place.in_shell("$F run room.yaml <&- >&- 2>&-").code == 0);
    CHECK(place.run({"store", "verify"}).code == 0);
#ifndef __SANITIZE_THREAD__  // It writes itself.
    CHECK(place.in_shell("(ulimit -f 0; $F run room.yaml --set start=5 --quiet 2> /dev/null)").code == 1);
#endif
}

TEST_CASE("Where results cannot go is said before anything runs")
{
    RoomPlace place;
    place.write("file.txt", "");
    fs::create_symlink("nowhere", place.file("link"));
    for (const std::string option : {"--out", "--store"})
        for (const auto& [folder, problem] : {std::pair("file.txt/below", "file.txt is not a folder"),
                                              {"file.txt", "file.txt is not a folder"},
                                              {"link/a", "link is not a folder"},
                                              {"o\xff", "is not UTF-8 text"}})
        {
            const Finished run = place.run({"run", "room.yaml", option, folder}, 2);
            for (const std::string& words : {"error: " + option + ": ", "choose another with " + option, std::string(problem)})
                CHECK(contains(run.err, words));
        }
    CHECK_FALSE(fs::exists(place.file("out")));
    CHECK_FALSE(fs::exists(place.file(".fresco/objects")));
    place.make({"--out", "o\xc3\xa4/b"});
}

TEST_CASE("Problems of a pipeline are JSON where JSON was asked for; a quiet run says nothing")
{
    Workplace place;
    place.write("bad.yaml", "version: 1\nstages:\n  source: {type: test.source, valu: 3}\n");
    const fresco::Value problems = fresco::parse_json(place.run({"plan", "bad.yaml", "--json"}).out).at("problems");
    CHECK(problems.as_list().at(0).at("line").as_int() == 3);
    const auto run = events(place.run({"run", "bad.yaml", "--json-log"}).out);
    REQUIRE(run.size() == 1);
    CHECK(run[0].at("exit_code").as_int() == 2);
    CHECK(run[0].at("problems") == problems);
    place.write("room.yaml", chain);
    const Finished quiet = place.make({"--quiet", "--store", "other"});
    CHECK((quiet.out + quiet.err).empty());
}

TEST_CASE("A file's name begins no line of a message")
{
    Workplace place;
    const std::string name = "no\nerror: all is lost\xe2\x80\xae.yaml";
    const Finished finished = place.run({"check", name}, 3);
    CHECK(contains(finished.err, "no\\nerror: all is lost\\u202e.yaml"));
    CHECK(std::ranges::count(finished.err, '\n') == 1);
    place.write("room.yaml", "version: 1\nstages:\n"
                             "  source: {type: test.source}\n"
                             "  text:   {type: test.sink, input: source, path: \"a\xe2\x80\xae.txt\"}\n");
    CHECK(contains(place.make().out, "out/a\\u202e.txt"));
}

TEST_CASE("describe says how a file was made")
{
    Workplace place;
    const std::string origin = R"({"versions": {"OpenCV": "4.6.0", "fresco": "0.1"}, "stages": [
        {"stage": "texture.synthesize", "options": {"mask": {"file": "m.png", "xxh128": "77"}},
         "inputs": {"mesh": "atlas.project", "style": {"file": "waves.jpg", "xxh128": "0123"}}, "figures": {"up": [0, 0, 1]}}]})";
    place.write("room.note", origin);
    CHECK(place.run({"describe", "room.note"}).out == "room.note: made with OpenCV 4.6.0, fresco 0.1\n"
                                                      "\ntexture.synthesize\n"
                                                      "  input   mesh   atlas.project\n"
                                                      "  input   style  waves.jpg (xxh128 0123)\n"
                                                      "  option  mask   m.png (xxh128 77)\n"
                                                      "  figure  up     [0,0,1]\n");
    CHECK(fresco::parse_json(place.run({"describe", "--json", "room.note"}).out) == fresco::parse_json(origin));
    // Text that moves the cursor or begins a line is escaped everywhere.
    const std::string evil = R"(\u001b]0;x\u0007\u009b1A\nok)";
    const std::string shown = R"(\x1b]0;x\x07\x9b1A\nok)";
    place.write("evil.note", R"({"versions": {")" + evil + R"(": ")" + evil + R"("}, "stages": [{"stage": ")" + evil +
                                 R"(", "options": {")" + evil + R"(": ")" + evil + R"("}, "inputs": {}}]})");
    CHECK(place.run({"describe", "evil.note"}).out ==
          "evil.note: made with " + shown + " " + shown + "\n\n" + shown + "\n  option  " + shown + "  " + shown + "\n");
    place.write("bad.note", "{");
    CHECK(contains(place.run({"describe", "bad.note"}, 1).err, "bad.note"));
    place.write("odd.note", R"({"stages": [1], "versions": {}})");
    place.run({"describe", "odd.note"}, 1);
    place.run({"describe", "gone.note"}, 3);
}

TEST_CASE("A program fresco-NAME is the command NAME, beside fresco and in PATH")
{
    Workplace place;
    const auto program = [&](const fs::path& folder, const std::string& name, const std::string& text)
    {
        fs::create_directories(folder);
        fresco::write_file(folder / name, "#!/bin/sh\n" + text);
        fs::permissions(folder / name, fs::perms::owner_all);
    };
    program(place.root() / "bin", "fresco-hello", "echo \"hello $*\"; exit 7\n");
    program(place.root() / "path", "fresco-hello", "echo other\n");
    program(place.root() / "path", "fresco-far-off", "kill -PIPE $$\n");
    program(place.root() / "path", "fresco-run", "echo not this one\n");
    fresco::write_file(place.root() / "path" / "fresco-text", std::string("no program"));
    place.environment["PATH"] = (place.root() / "path").string() + ":/usr/bin:/bin";
    CHECK(place.run({"hello", "--out", "a b"}, 7).out == "hello --out a b\n");
    // It gets the signals that fresco ignores.
    CHECK(place.run({"far-off"}).code == -SIGPIPE);
    CHECK_FALSE(contains(place.run({"run", "--help"}).out, "not this one"));
    CHECK(contains(place.run({"--help"}).out, "Programs, as commands: far-off, hello\n"));
    CHECK(contains(place.run({"helo"}, 2).err, "unknown command 'helo' (did you mean 'hello'?)"));
    place.run({"text"}, 2);
    CHECK(contains(place.run({"internal-complete", "1", "--", "fresco", "he"}).out, "hello"));
    // Only what lies beside fresco is asked.
    program(place.root() / "bin", "fresco-asked", "echo \"$*\"\n");
    CHECK(place.run({"internal-complete", "3", "--", "fresco", "asked", "a", "b"}).out == "internal-complete a b\n");
    CHECK(place.run({"internal-complete", "2", "--", "fresco", "far-off", ""}).out.empty());
}
