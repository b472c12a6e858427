#pragma once

#include "started_program.h"

#include <fresco/testing.h>
#include <fresco/value.h>

#include <algorithm>
#include <memory>
#include <sstream>

/// \file For tests that run the real program in a folder of its own.

using Words = std::vector<std::string>;

inline Words lines_of(const std::string& text)
{
    Words lines;
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);)
        lines.push_back(line);
    return lines;
}

inline fs::path test_plugin(const std::string& name)
{
    return fs::path(FRESCO_TEST_PLUGINS) / name;
}

/// A working folder with the program away from installed plugins; it has only those of FRESCO_PLUGIN_PATH.
class Workplace
{
  public:
    /// `plugins`: folders below the test plugins' folder.
    explicit Workplace(const Words& plugins = {"good"})
    {
        for (const char* name : {"bin", "home", "work"})
            fs::create_directories(root() / name);
        fs::copy_file(FRESCO_PROGRAM, root() / "bin" / "fresco");
        std::string path;
        for (const auto& folder : plugins)
            path += (path.empty() ? "" : ":") + test_plugin(folder).string();
        environment = {{"FRESCO_PLUGIN_PATH", path},
                       {"HOME", root() / "home"},
                       {"XDG_DATA_HOME", root() / "home/data"},
                       {"LD_LIBRARY_PATH", fs::path(FRESCO_SDK_LIBRARY).parent_path()}};
    }

    std::map<std::string, std::string> environment;

    fs::path root() const { return folder_.path(); }
    fs::path work() const { return root() / "work"; }
    fs::path file(const std::string& name) const { return work() / name; }
    void write(const std::string& name, const std::string& text) const
    {
        fs::create_directories(file(name).parent_path());
        std::ofstream(file(name)) << text;
    }
    std::string read(const std::string& name) const { return fs::exists(file(name)) ? fresco::read_text_file(file(name)) : ""; }
    fresco::Value read_json(const std::string& name) const { return fresco::parse_json(read(name), name); }

    /// Lines of the log that the test stages write.
    Words log() const { return lines_of(read("log")); }
    std::size_t logged(const std::string& beginning) const
    {
        const Words lines = log();
        return static_cast<std::size_t>(
            std::ranges::count_if(lines, [&](const std::string& line) { return line.starts_with(beginning); }));
    }
    void clear_log() const { fs::remove(file("log")); }
    std::vector<fs::path> objects(const std::string& store = ".fresco") const
    {
        return {fs::directory_iterator(file(store + "/objects")), fs::directory_iterator()};
    }

    std::unique_ptr<Background> start(Words arguments)
    {
        arguments.insert(arguments.begin(), root() / "bin/fresco");
        const std::string number = std::to_string(++count_);
        return std::make_unique<Background>(arguments, environment, work(), root() / ("out" + number), root() / ("err" + number));
    }
    Finished run(const Words& arguments) { return start(arguments)->wait(); }
    /// It must end with this code.
    Finished run(const Words& arguments, int code)
    {
        Finished finished = run(arguments);
        INFO(finished.err);
        REQUIRE(finished.code == code);
        return finished;
    }
    /// `fresco run room.yaml` with more words, which must end well.
    Finished make(Words more = {})
    {
        more.insert(more.begin(), {"run", "room.yaml"});
        return run(more, 0);
    }
    /// Makes these the stages of room.yaml, from line 3 on.
    void write_stages(const std::string& stages) const { write("room.yaml", "version: 1\nstages:" + stages); }
    /// Commands in a shell; the program is $F.
    Finished in_shell(const std::string& commands)
    {
        const std::string script = "ulimit -c 0\nF='" + (root() / "bin/fresco").string() + "'\n" + commands + "\n";
        return Background({"/bin/bash", "-c", script}, environment, work(), root() / "shell.out", root() / "shell.err").wait();
    }

  private:
    fresco::testing::TemporaryFolder folder_;
    int count_ = 0;
};

/// A source, a stage and an export, each with a line in the file "log" for every run.
inline const std::string chain = R"(version: 1
vars: {start: 4}
stages:
  source: {type: test.source, value: "${start}", log: log}
  add:    {type: test.add, input: {left: source}, plus: 1, log: log}
  text:   {type: test.sink, input: add, path: x.txt, log: log}
)";

/// A workplace with room.yaml: these stages, or a whole text with its version.
struct RoomPlace : Workplace
{
    explicit RoomPlace(const std::string& text = chain, const Words& plugins = {"good"}) : Workplace(plugins)
    {
        write("room.yaml", text.starts_with("version") ? text : "version: 1\nstages:" + text);
    }
};

/// The events of `--json-log`; with `name`, those of this name.
inline std::vector<fresco::Value> events(const std::string& out, const std::string& name = "")
{
    std::vector<fresco::Value> list;
    for (const std::string& line : lines_of(out))
        if (fresco::Value event = fresco::parse_json(line, "event"); name.empty() || event.at("event").as_string() == name)
            list.push_back(std::move(event));
    return list;
}

/// An entry of each stage's outcome, from the summary that ends `--json-log`.
inline std::map<std::string, std::string> outcomes(const Finished& finished, const char* entry = "state")
{
    std::map<std::string, std::string> result;
    const auto all = events(finished.out);
    REQUIRE(!all.empty());
    for (const auto& stage : all.back().at("stages").as_list())
        result[stage.at("stage").as_string()] = stage.at(entry).as_string();
    return result;
}

/// Contents of a page's script "data" or "media".
inline fresco::Value page_json(const std::string& page, const std::string& id)
{
    const std::string begin = "<script type=\"application/json\" id=\"" + id + "\">";
    const std::size_t from = page.find(begin);
    REQUIRE(from != std::string::npos);
    const std::size_t at = from + begin.size();
    return fresco::parse_json(page.substr(at, page.find("</script>", at) - at), id);
}
