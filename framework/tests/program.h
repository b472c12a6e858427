#pragma once

#include "catch.h"

#include <fresco/files_io.h>
#include <fresco/testing.h>
#include <fresco/value.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>
#include <vector>

/// \file For tests that run the real program in a folder of its own.

namespace fs = std::filesystem;

struct Finished
{
    int code = -1;  ///< Exit code, or minus the signal.
    std::string out;
    std::string err;
    double seconds = 0;
};

/// A run of the program that goes on beside the test.
class Background
{
  public:
    Background(pid_t pid, fs::path out, fs::path err) : pid_(pid), out_(std::move(out)), err_(std::move(err)) {}
    Background(const Background&) = delete;
    Background& operator=(const Background&) = delete;
    ~Background()
    {
        if (pid_ > 0)
        {
            kill(pid_, SIGKILL);
            waitpid(pid_, nullptr, 0);
        }
    }
    void signal(int number) const { kill(pid_, number); }
    /// A process that the program started and that runs; fails the test if there is none.
    pid_t a_child() const
    {
        const std::string id = std::to_string(pid_);
        std::ifstream children("/proc/" + id + "/task/" + id + "/children");
        pid_t child = 0;
        REQUIRE(children >> child);
        return child;
    }
    Finished wait()
    {
        int status = 0;
        waitpid(pid_, &status, 0);
        pid_ = -1;
        Finished result;
        result.code = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
        result.out = fresco::read_text_file(out_);
        result.err = fresco::read_text_file(err_);
        result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
        return result;
    }

  private:
    pid_t pid_;
    fs::path out_;
    fs::path err_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// A working folder with the program away from installed plugins; it has only those of FRESCO_PLUGIN_PATH.
class Workplace
{
  public:
    /// `plugins`: folders below the test plugins' folder. The cache of descriptions is shared by all tests unless `own_cache`.
    explicit Workplace(const std::vector<std::string>& plugins = {"good"}, bool own_cache = false)
    {
        for (const char* name : {"bin", "home", "work"})
            fs::create_directories(root() / name);
        fs::copy_file(FRESCO_PROGRAM, root() / "bin" / "fresco");
        std::string path;
        for (const auto& folder : plugins)
            path += (path.empty() ? "" : ":") + (fs::path(FRESCO_TEST_PLUGINS) / folder).string();
        environment["FRESCO_PLUGIN_PATH"] = path;
        environment["HOME"] = (root() / "home").string();
        environment["XDG_DATA_HOME"] = (root() / "home" / "data").string();
        environment["XDG_CACHE_HOME"] = own_cache ? (root() / "home" / "cache").string() : shared_cache().path().string();
        environment["LD_LIBRARY_PATH"] = fs::path(FRESCO_SDK_LIBRARY).parent_path().string();
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
    /// Lines of the log that the test stages write.
    std::vector<std::string> log() const
    {
        std::vector<std::string> lines;
        std::ifstream stream(file("log"));
        for (std::string line; std::getline(stream, line);)
            lines.push_back(line);
        return lines;
    }
    void clear_log() const { fs::remove(file("log")); }

    std::unique_ptr<Background> start(const std::vector<std::string>& arguments)
    {
        const std::string number = std::to_string(++count_);
        const fs::path out = root() / ("out" + number);
        const fs::path err = root() / ("err" + number);
        std::vector<std::string> texts{(root() / "bin" / "fresco").string()};
        texts.insert(texts.end(), arguments.begin(), arguments.end());
        std::vector<char*> argv;
        for (auto& text : texts)
            argv.push_back(text.data());
        argv.push_back(nullptr);
        std::fflush(nullptr);
        const pid_t pid = fork();
        REQUIRE(pid >= 0);
        if (pid == 0)
        {
            if (chdir(work().c_str()) != 0 || freopen(out.c_str(), "w", stdout) == nullptr ||
                freopen(err.c_str(), "w", stderr) == nullptr)
                _exit(126);
            for (const auto& [name, value] : environment)
                setenv(name.c_str(), value.c_str(), 1);
            execv(argv[0], argv.data());
            _exit(127);
        }
        return std::make_unique<Background>(pid, out, err);
    }
    Finished run(const std::vector<std::string>& arguments) { return start(arguments)->wait(); }

    /// Waits until something holds; fails the test after 20 s.
    template <class Condition>
    static void wait_until(Condition condition)
    {
        for (int i = 0; i < 2000; ++i)
        {
            if (condition())
                return;
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        }
        FAIL("waited for 20 s");
    }

  private:
    static fresco::testing::TemporaryFolder& shared_cache()
    {
        static fresco::testing::TemporaryFolder folder;
        return folder;
    }

    fresco::testing::TemporaryFolder folder_;
    int count_ = 0;
};

/// The events of `--json-log`.
inline std::vector<fresco::Value> events(const std::string& out)
{
    std::vector<fresco::Value> list;
    std::istringstream stream(out);
    for (std::string line; std::getline(stream, line);)
        list.push_back(fresco::parse_json(line, "event"));
    return list;
}

/// Stage -> state, of the summary that ends `--json-log`.
inline std::map<std::string, std::string> states(const Finished& finished)
{
    std::map<std::string, std::string> result;
    const auto all = events(finished.out);
    REQUIRE(!all.empty());
    for (const auto& stage : all.back().at("stages").as_list())
        result[stage.at("stage").as_string()] = stage.at("state").as_string();
    return result;
}

/// What a page holds in its script "data" or "media".
inline fresco::Value page_json(const std::string& page, const std::string& id)
{
    const std::string begin = "<script type=\"application/json\" id=\"" + id + "\">";
    const std::size_t from = page.find(begin);
    REQUIRE(from != std::string::npos);
    const std::size_t at = from + begin.size();
    return fresco::parse_json(page.substr(at, page.find("</script>", at) - at), id);
}

inline bool contains(const std::string& text, const std::string& part)
{
    const bool found = text.find(part) != std::string::npos;
    if (!found)
        UNSCOPED_INFO("\"" << part << "\" is not in:\n" << text);
    return found;
}
