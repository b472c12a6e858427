#pragma once

#include "program.h"

#include "store/publish.h"
#include "store/store.h"

#include <set>

/// \file What tests of the store write into one.

namespace fresco::host
{

inline void write(const fs::path& file, const std::string& text)
{
    fs::create_directories(file.parent_path());
    std::ofstream(file) << text;
}

/// As `touch` does.
inline void touch(const fs::path& file, int hours_ago)
{
    fs::last_write_time(file, fs::file_time_type::clock::now() - std::chrono::hours(hours_ago));
}

/// Waits until stamps of what was just written are trusted. Nobody can set the time of the last change.
inline void let_stamps_settle()
{
    std::this_thread::sleep_for(std::chrono::milliseconds(2100));
}

inline std::vector<std::string> names_in(const fs::path& folder)
{
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder))
        names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
}

/// A store that goes away with the object. It is the folder "store" of a folder of its own, for what lies beside it.
struct OwnStore : fresco::testing::TemporaryFolder, Store
{
    OwnStore() : Store(path() / "store") {}
};

/// The result of a key: one output, out/a.json with `text`.
inline StoredResult publish_text(const Store& store, const std::string& key, const std::string& text,
                                 const std::vector<Dependency>& dependencies = {}, const std::set<std::string>& references = {})
{
    const fs::path folder = store.make_temporary();
    write(folder / "out" / "a.json", text);
    return publish(store, folder,
                   {key, {"out"}, dependencies, Value::Map{{"stage", "s"}, {"type", "t.t"}, {"time_s", 0}}, references});
}

/// Runs it in as many processes at once. All must end well.
template <class Work>
inline void in_processes(int count, const Work& work)
{
    std::vector<pid_t> children;
    for (int i = 0; i < count; ++i)
        if (children.push_back(fork()); children.back() == 0)
        {
            try
            {
                work(i);
                _exit(0);
            }
            catch (...)
            {
                _exit(1);
            }
        }
    for (const pid_t child : children)
        CHECK(code_of(child) == 0);
}

}  // namespace fresco::host
