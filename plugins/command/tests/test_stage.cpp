#include "terminal.h"

namespace
{

const std::vector<std::string> plugins{"good", FRESCO_COMMAND_ALONE};

/// Adds one to the number in a table, by a script.
const char* const pipeline = R"(version: 1
vars: {by: 1, wait: 0}
stages:
  source: {type: test.source, value: 5, log: log}
  more:
    type: command
    run: [sh, add.sh, "{number}", "{sum}", "${by}", "${wait}"]
    files: [add.sh]
    input: {number: source}
    inputs: {number: table}
    outputs: {sum: table}
  text: {type: test.sink, input: more, path: sum.txt, log: log}
)";

const char* const script = R"(echo run >>"$(dirname "$0")/log"
value=$(sed 's/.*\[\[\?\([0-9]*\).*/\1/' "$1" | grep -o '[0-9][0-9]*' | head -1)
echo "fresco: progress 1/2 numbers"
echo "fresco: metric loss 0.5"
sleep "$4"
echo "fresco: warning a small number"
echo "fresco: report value [$value]"
echo "adding $3" >&2
printf '{"columns": ["value"], "rows": [[%d]]}' $((value + $3)) >"$2"
)";

/// A pipeline with one command that makes a table.
std::string shell(const std::string& words)
{
    return "version: 1\nstages:\n  made:\n    type: command\n    run: [sh, -c, '" + words +
           "', sh, \"{out}\"]\n    outputs: {out: table}\n  text: {type: test.sink, input: made, path: x.txt}\n"
           "  other: {type: test.source, value: 2}\n  good: {type: test.sink, input: other, path: good.txt}\n";
}

/// A pipeline of one command, with these options.
std::string command(const std::string& options)
{
    return "version: 1\nstages:\n  made: {type: command, " + options + "}\n";
}

/// The process has ended, though nobody may have taken its end yet: it has no words.
bool has_ended(const std::string& pid)
{
    return std::ifstream("/proc/" + std::to_string(std::stoi(pid)) + "/cmdline").get() == std::ifstream::traits_type::eof();
}

/// Writes a table to the file that the first word names. In a word of `run` braces are doubled.
const char* const table = "printf \"{\\\"columns\\\": [\\\"value\\\"], \\\"rows\\\": [[7]]}\" >\"$1\"";
const char* const table_word = "printf \"{{\\\"columns\\\": [\\\"value\\\"], \\\"rows\\\": [[7]]}}\" >\"$1\"";

struct WithPlace
{
    Workplace place{plugins};
};

}  // namespace

TEST_CASE("a program is a stage: it takes inputs, makes outputs, reports progress, and runs again only for a reason", "[command]")
{
    RoomPlace place(pipeline, plugins);
    place.write("add.sh", script);
    const Finished first = place.run({"run", "room.yaml", "--json-log", "--set", "wait=0.2"});
    INFO(first.err << first.out);
    REQUIRE(first.code == 0);
    CHECK(place.read("out/sum.txt") == "6.000000\n");
    const auto told = [all = events(first.out)](const char* name, const char* key, const fresco::Value& value)
    {
        return std::ranges::any_of(all, [&](const auto& event)
                                   { return event.at("event").as_string() == name && event.at(key) == value; });
    };
    CHECK(told("progress", "unit", "numbers"));
    CHECK(told("progress", "total", 2.0));
    CHECK(told("warning", "text", "a small number"));
    CHECK(told("message", "text", "adding 1"));
    CHECK(fs::is_empty(place.file(".fresco/tmp")));

    const auto runs = [&](const std::vector<std::string>& sets)
    {
        place.clear_log();
        std::vector<std::string> arguments{"run", "room.yaml", "--set", "wait=0.2"};
        arguments.insert(arguments.end(), sets.begin(), sets.end());
        CHECK(place.run(arguments).code == 0);
        const auto log = place.log();
        return std::count(log.begin(), log.end(), "run");
    };
    CHECK(runs({}) == 0);
    CHECK(runs({"--set", "by=3"}) == 1);
    CHECK(place.read("out/sum.txt") == "8.000000\n");
    CHECK(runs({"--set", "more.version=2"}) == 1);
    CHECK(runs({}) == 0);
    place.write("add.sh", std::string(script) + "# changed\n");
    CHECK(contains(place.run({"plan", "room.yaml", "--set", "wait=0.2"}).out, "among the files, add.sh changed"));
    CHECK(runs({}) == 1);
    // Elsewhere the same script is the same script.
    place.write("moved/add.sh", place.read("add.sh"));
    place.write("moved/room.yaml", pipeline);
    CHECK(place.run({"run", "moved/room.yaml", "--set", "wait=0.2"}).code == 0);
    CHECK(!fs::exists(place.file("moved/log")));
}

TEST_CASE_METHOD(WithPlace,
                 "a program that fails is named with its command, its end and what it printed last, and nothing else is lost",
                 "[command]")
{
    const std::vector<std::pair<std::string, std::vector<std::string>>> ways{
        {"echo first; echo last words >&2; exit 3", {"ended with exit code 3; the last it printed:", "| last words"}},
        {"kill -SEGV $$", {"was killed by a signal: Segmentation fault (signal 11); it printed nothing"}},
        {"true", {"the program succeeded, but its output", "(table) cannot be used: ", "table.json was not written"}},
        {"echo {{}} >\"$1\"", {"cannot be used: ", "columns"}},
        {"exit 75", {"ended with exit code 75"}}};
    for (const auto& [words, expected] : ways)
    {
        INFO(words);
        fs::remove_all(place.file("out"));
        place.write("room.yaml", shell(words));
        const Finished finished = place.run({"run", "room.yaml"});
        CHECK(finished.code == 1);
        CHECK(contains(finished.err, "room.yaml:3:3: error: stage made (command): "));
        for (const auto& text : expected)
            CHECK(contains(finished.err, text));
        CHECK(fs::exists(place.file("out/good.txt")));
        CHECK_FALSE(fs::exists(place.file("out/x.txt")));
        CHECK(fs::is_empty(place.file(".fresco/tmp")));
    }
}

TEST_CASE_METHOD(WithPlace, "a program runs in a folder of its own, with the cores it may use, and no shell in between",
                 "[command]")
{
    const fs::path temporary = place.root() / "temporary";
    fs::create_directory(temporary);
    place.environment["TMPDIR"] = temporary.string();
    place.write(
        "room.yaml",
        shell(std::string(
                  "pwd; echo cores $FRESCO_THREADS $OMP_NUM_THREADS; echo tmp $TMPDIR; ls; cat; ls /proc/self/fd | wc -l; ") +
              "echo \"rest $0\"; " + table_word));
    const Finished finished = place.run({"run", "room.yaml", "--cores", "1"});
    INFO(finished.err);
    REQUIRE(finished.code == 0);
    CHECK(contains(finished.err, "made: " + temporary.string() + "/fresco-"));
    CHECK(contains(finished.err, "cores 1 1\n"));
    CHECK(contains(finished.err, "tmp " + temporary.string() + "/fresco-"));
    CHECK(fs::is_empty(temporary));
    // Input, output, error, and what ls opens itself.
    CHECK(contains(finished.err, "made: 4\n"));

    place.write("plain.yaml", command("run: [echo, \"$(touch broken)\", \"; rm -rf *\", \"{o}\"], outputs: {o: files}"));
    const Finished plain = place.run({"run", "plain.yaml"});
    CHECK(contains(plain.err, "made: $(touch broken) ; rm -rf * "));
    CHECK(contains(plain.err, "no file was written into it"));
    CHECK_FALSE(fs::exists(place.file("broken")));

    // A script of the user's own is run by itself.
    place.write("a.sh", "#!/bin/sh\n" + std::string(table) + "\n");
    fs::permissions(place.file("a.sh"), fs::perms::owner_all);
    place.write("room.yaml", command("run: [a.sh, \"{o}\"], files: [a.sh], outputs: {o: table}") +
                                 "  text: {type: test.sink, input: made, path: x.txt}\n");
    place.make();
    CHECK(place.read("out/x.txt") == "7.000000\n");
}

TEST_CASE("a log without end is cut for people, and a program's strange bytes do no harm", "[command]")
{
    RoomPlace place(
        shell("for i in $(seq 1000); do echo line $i; done; printf \"\\377\\033[31m\\001x\"; " + std::string(table_word)),
        plugins);
    const Finished finished = place.make();
    CHECK(contains(finished.err, "made: line 200\n"));
    CHECK(finished.err.find("line 201\n") == std::string::npos);
    CHECK(contains(finished.err, "it prints more; all of it is in --json-log"));
    const Finished json = place.make({"--json-log", "--store", "again"});
    CHECK(contains(json.out, "line 1000"));
    CHECK(contains(json.out, "\"text\":\"? x\""));
}

TEST_CASE("of words without end a result keeps the first", "[command]")
{
    RoomPlace place(shell("for i in $(seq 1500); do echo fresco: message word $i; done; " + std::string(table_word)), plugins);
    place.make({"--until", "made"});
    const std::string manifest = fresco::read_text_file(place.objects().at(0) / "manifest.json");
    CHECK(fresco::parse_json(manifest).at("messages").as_list().size() == 1001);
}

TEST_CASE_METHOD(WithPlace, "stopping a run stops the program and all it started", "[command]")
{
    // The first sleeps in a process of its own; the second takes no hint.
    const std::string words = GENERATE("sleep 300 & echo $! >\"$(dirname \"$0\")/pid\"; wait",
                                       "trap : TERM; echo $$ >\"$(dirname \"$0\")/pid\"; while :; do sleep 0.1; done");
    place.write("slow.sh", words);
    place.write("room.yaml", command("run: [sh, slow.sh, \"{o}\"], files: [slow.sh], outputs: {o: table}"));
    const auto run = place.start({"run", "room.yaml"});
    wait_until([&] { return !place.read("pid").empty(); });
    run->signal(SIGTERM);
    CHECK(run->wait().code == 75);
    CHECK(has_ended(place.read("pid")));
    CHECK(fs::is_empty(place.file(".fresco/tmp")));
}

TEST_CASE_METHOD(WithPlace, "a program ends with the host, and so does all it started", "[command]")
{
    place.write("slow.sh", "trap : TERM\n(trap : TERM; sh -c 'echo $PPID' >\"$1\"; while :; do sleep 0.1; done) &\nexec yes\n");
    place.write("room.yaml", command("run: [sh, slow.sh, " + place.file("pid").string() +
                                     ", \"{o}\"], files: [slow.sh], outputs: {o: table}"));
    const auto run = place.start({"run", "room.yaml"});
    wait_until([&] { return !place.read("pid").empty(); });
    run->signal(SIGKILL);
    run->wait();
    wait_until([&] { return has_ended(place.read("pid")); });
}

TEST_CASE_METHOD(WithPlace, "what a program leaves behind ends before its outputs are taken", "[command]")
{
    // A session of its own, and nobody who waits for it.
    place.write("left.sh",
                "setsid sh -c 'echo $$ >\"$0\"; while :; do echo more >>\"$1\"; sleep 0.01; done' \"$PWD/pid\" \"$1/log\" &\n"
                "while [ ! -s pid ] || [ ! -s \"$1/log\" ]; do sleep 0.01; done; cp pid \"$1/pid\"\n");
    place.write("room.yaml", command("run: [sh, left.sh, \"{o}\"], files: [left.sh], outputs: {o: files}"));
    place.make();
    CHECK(has_ended(place.read("out/pid")));
    CHECK(place.run({"store", "verify"}).code == 0);
}

TEST_CASE("the limit of memory holds for programs, too", "[command][isolation]")
{
    RoomPlace place(shell("x=0123456789abcdef; while :; do x=$x$x; done"), plugins);
    const Finished large = place.run({"run", "room.yaml", "--stage-memory", "200M"});
    CHECK(large.code == 1);
    CHECK(contains(large.err, "stage made (command): "));
    CHECK(fs::exists(place.file("out/good.txt")));
}

TEST_CASE_METHOD(WithPlace, "a program beyond its time that hears no signal is ended with all it started, wherever that went",
                 "[command][isolation]")
{
    place.write("deaf.sh", "trap : TERM\nif [ \"$2\" = left ]; then echo $$ >\"$1\"; else setsid sh \"$0\" \"$1\" left & fi\n"
                           "while :; do sleep 0.1; done\n");
    place.write("room.yaml", command("run: [sh, deaf.sh, " + place.file("pid").string() +
                                     ", first, \"{o}\"], files: [deaf.sh], outputs: {o: table}"));
    // On a busy machine the second may not be there yet when the time is up.
    for (int seconds = 3; place.read("pid").empty(); seconds *= 3)
    {
        const Finished late = place.run({"run", "room.yaml", "--stage-time", std::to_string(seconds) + "s"});
        CHECK(late.code == 1);
        CHECK(contains(late.err, "stage made (command): it exceeded the time limit of "));
    }
    CHECK(has_ended(place.read("pid")));
}

TEST_CASE_METHOD(WithPlace, "everything wrong with a command is reported before anything runs", "[command]")
{
    struct Wrong
    {
        const char* stage;
        const char* told;
        int code = 2;
    };
    const std::vector<Wrong> all{
        {"run: [sh, \"{x}\"], outputs: {o: table}", "{x} in 'run' is neither a port nor among 'files' (there are: o)"},
        {"run: [sh], outputs: {o: table}", "no word of 'run' says where the output 'o' goes: write \"{o}\""},
        {"run: [sh, \"{o\"], outputs: {o: table}", "'{o' has a '{' without its other"},
        {"run: [sh, {o: x}], outputs: {o: table}", "expected a word, got a map (a word with braces is written in quotes)"},
        {"run: sh, outputs: {o: table}", "option 'run': expected a list of words, got the text 'sh'"},
        {"run: [], outputs: {o: table}", "option 'run' is empty: name a program"},
        {"run: [sh], outputs: {}", "a command needs at least one output"},
        {"run: [sh, \"{o}\"], outputs: {o: tabel}", "unknown artifact 'tabel' (did you mean 'table'?)"},
        {"run: [sh, \"{o}\"], outputs: {o: {artifact: image, as: jpg}}",
         "expected one of npy, png for 'as' of port 'o', got the text 'jpg'"},
        {"run: [sh, \"{o}\"], outputs: {o: {artifact: mesh, as: ply}}", "mesh has only one form; leave 'as' out"},
        {"run: [sh, \"{o}\"], outputs: {o: {artifact: mesh, form: ply}}", "has no 'form' (there are: artifact, as)"},
        {"run: [sh, \"{o}\"], outputs: {o: }", "port 'o': expected an artifact such as mesh"},
        {"run: [sh, \"{o}\"], outputs: {\"o o\": table}", "a name is made of letters, digits, '_' and '-'"},
        {"run: [sh, \"{o}\"], outputs: {o: table}, inputs: {o: table}, input: source", "'o' is an input and an output"},
        {"run: [sh, \"{o}\"], outputs: {o: table}, inputs: {i: table}", "needs the input 'i' (table)"},
        {"run: [sh, \"{o}\"], outputs: {o: table}, input: source", "takes no input: declare its ports by 'inputs'"},
        {"run: [sh, \"{o}\"], outputs: {o: table}, inputs: {i: mesh}, input: source",
         "'source' is table (table); expected i (mesh)"},
        {"run: [sh, a.sh, \"{o}\"], outputs: {o: table}", "'a.sh' is a file here, but not among 'files': add it there"},
        {"run: [./a.sh, \"{o}\"], outputs: {o: table}", "'./a.sh' is a relative path that is not among 'files'"},
        {"run: [\"{o}\"], outputs: {o: table}", "the program cannot be a {name}"},
        {"run: [sh, \"{o}\"], outputs: {o: table}, vesion: 2", "has no option 'vesion' (did you mean 'version'?)"},
        {"run: [sh, \"{o}\"], outputs: {o: table}, files: [b.sh]", "option 'files': no such file '", 3},
        {"run: [a.sh, \"{o}\"], outputs: {o: table}, files: [a.sh]", "may not be executed: chmod +x", 3},
        {"run: [fresco-no-such-program, \"{o}\"], outputs: {o: table}", "no program 'fresco-no-such-program' in PATH", 3},
        {"run: [/no/such, \"{o}\"], outputs: {o: table}", "no program '/no/such'", 3}};
    place.write("a.sh", "echo a\n");
    for (const Wrong& wrong : all)
    {
        INFO(wrong.stage);
        place.write("room.yaml", command(wrong.stage) + "  source: {type: test.source}\n");
        const Finished finished = place.run({"check", "room.yaml"});
        CHECK(finished.code == wrong.code);
        CHECK(contains(finished.out + finished.err, wrong.told));
        CHECK(contains(finished.out + finished.err, "room.yaml:3:"));
    }
}

TEST_CASE("an artifact type of a plugin is exchanged like those of the SDK", "[command]")
{
    Workplace place({"good", "note", FRESCO_COMMAND_ALONE});
    const auto write = [&](const std::string& script, const std::string& form)
    {
        const std::string twice = "run: [sh, -c, 'cat \"$1\" \"$1\" >\"$2/note.txt\"', sh, \"{in}\", \"{out}\"], input: {in: "
                                  "louder}, inputs: {in: {artifact: test_note, as: json}}, outputs: {out: test_note}";
        place.write("room.yaml",
                    command(twice) + "  note: {type: test.note, text: hello}\n  louder: {type: command, run: [sh, -c, '" +
                        script + "', sh, \"{in}/note.txt\", \"{out}\"], input: {in: note}, inputs: {in: test_note}, " +
                        "outputs: {out: {artifact: test_note, as: " + form + "}}}\n");
    };
    write("tr a-z A-Z <\"$1\" >\"$2\"", "json");
    // The artifact type refuses what is not JSON.
    const Finished wrong = place.run({"run", "room.yaml"});
    CHECK(wrong.code == 1);
    CHECK(contains(wrong.err, "its output 'out' (test_note) cannot be used: "));
    write("echo \"\\\"$(tr a-z A-Z <\"$1\")\\\"\" >\"$2\"", "json");
    place.make();
    std::string made;
    for (const fs::path& object : place.objects())
        if (fs::exists(object / "out/note.txt"))
            made += fresco::read_text_file(object / "out/note.txt") + ";";
    CHECK(contains(made, "HELLO;"));
    CHECK(contains(made, "\"HELLO\"\"HELLO\";"));
    write("true", "xml");
    CHECK(contains(place.run({"check", "room.yaml"}).err, "expected one of folder, json for 'as' of port 'out'"));
}

TEST_CASE("a program that opens the terminal gets an error, and the run goes on")
{
    RoomPlace place(command("run: [sh, -c, 'read -r answer </dev/tty', sh, \"{o}\"], outputs: {o: table}"), plugins);
    Terminal terminal(place, {"run", "room.yaml", "--stage-time", "100s"}, 600, 12);
    REQUIRE(terminal.shows("ended with exit code"));
    CHECK(terminal.finish() == 1);
}
