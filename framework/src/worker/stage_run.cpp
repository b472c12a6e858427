#include "worker/stage_run.h"
#include "base/common.h"
#include "base/fault.h"
#include "base/machine.h"
#include "base/process.h"
#include "store/publish.h"
#include "worker/worker_factory.h"
#include <fresco/error.h>
#include <fresco/file_access.h>
#include <fresco/process.h>
#include <fresco/reader.h>
#include <fresco/stage.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fmt/ranges.h>
#include <map>
#include <memory>
#include <set>
#include <sys/stat.h>
#include <thread>
#include <unistd.h>
#include <utility>

namespace fresco::host
{

namespace
{

constexpr std::size_t most_stages = 100;
constexpr std::size_t longest_list = 4;
constexpr std::size_t longest_map = 16;
constexpr std::size_t most_entries = 64;

/// An input file as the key has it, under the name that the user gave it.
Value named_file(const Value& identity, const std::string& path)
{
    return Value::Map{{"file", std::filesystem::path(path).filename().string()}, {"xxh128", identity.at("contents")}};
}

bool is_file_identity(const Value& key)
{
    return key.find("contents") != nullptr && key.find("extension") != nullptr;
}

/// An option as the key has it; `given`: the same as the stage gets it, with the names of files. Null: unknown.
Value told_option(const Value& key, const Value* given)
{
    if (is_file_identity(key))
        return named_file(key, given != nullptr && given->is_string() ? given->as_string() : "");
    if (key.is_string())
        return without_folders(key.as_string());
    if ((key.is_list() && key.as_list().size() > most_entries) || (key.is_map() && key.as_map().size() > most_entries))
        return "more than " + std::to_string(most_entries) + " entries";
    if (key.is_list())
        return each<Value>(key.as_list(), [&](const Value& entry) { return told_option(entry, nullptr); });
    if (!key.is_map())
        return key;
    const Value* options = key.find("type") != nullptr ? key.find("options") : nullptr;
    Value::Map map;
    if (options != nullptr)
        map.emplace_back("type", key.at("type"));
    for (const auto& [name, value] : (options != nullptr ? *options : key).as_map())
        map.emplace_back(name, told_option(value, given == nullptr ? nullptr : given->find(name)));
    return map;
}

bool is_time(std::string_view name)
{
    return name.ends_with("_s") || name.find("seconds") != std::string_view::npos;
}

bool is_plain(const Value& value)
{
    return value.is_bool() || value.is_number() || value.is_string();
}

Value lasting_entries(const Value::Map& map);

/// Null: nothing to keep.
Value lasting(const Value& value)
{
    if (value.is_string())
        return without_folders(value.as_string());
    if (is_plain(value))
        return value;
    if (value.is_list() && value.as_list().size() <= longest_list && std::ranges::all_of(value.as_list(), is_plain))
        return told_option(value, nullptr);
    return value.is_map() && value.as_map().size() <= longest_map ? lasting_entries(value.as_map()) : Value();
}

/// Entries that stay in the manifest.
Value lasting_entries(const Value::Map& map)
{
    Value::Map kept;
    for (const auto& [name, entry] : map)
        if (Value figure = is_time(name) ? Value() : lasting(entry); !figure.is_null())
            kept.emplace_back(name, std::move(figure));
    return kept.empty() ? Value() : Value(std::move(kept));
}

/// Stages in an earlier result's manifest, the last one under the name of the result.
Value::List earlier_stages(const Store& store, const std::string& object)
{
    const Value manifest = store.manifest(object);
    const Value* origin = manifest.find("origin");
    if (origin == nullptr || origin->as_list().empty())
        return {};
    Value::List stages = origin->as_list();
    stages.back().set("result", object);
    return stages;
}

/// An entry for each stage upstream of the request, in a topological order, and for the request itself, last: {result, type,
/// options, inputs, versions, figures}; the last has neither result nor figures yet. Of more than 100 stages the last 100. The
/// same for equal results, whatever the paths of the user's files.
Value origin_of(const WorkerRequest& request, const Store& store, Value versions)
{
    std::vector<WorkerInput> inputs = request.inputs;
    std::ranges::sort(inputs, {}, &WorkerInput::port);
    Value::List stages;
    std::set<std::string> known;
    Value::Map from;
    for (const WorkerInput& input : inputs)
    {
        if (input.object.empty())
        {
            from.emplace_back(input.port, named_file(request.key_document.at("inputs").at(input.port), input.file.string()));
            continue;
        }
        from.emplace_back(input.port, Value::Map{{"result", input.object}, {"output", input.output}});
        for (Value& stage : earlier_stages(store, input.object))
            if (known.insert(stage.at("result").as_string()).second)
                stages.push_back(std::move(stage));
    }
    stages.push_back(Value::Map{{"type", request.type},
                                {"options", told_option(request.key_document.at("options"), &request.options)},
                                {"inputs", std::move(from)},
                                {"versions", std::move(versions)}});
    if (stages.size() > most_stages)
        stages.erase(stages.begin(), stages.end() - most_stages);
    return stages;
}

/// As RunContext::origin tells it: results by the types of their stages, the versions of all in one map.
Value told_origin(const Value& origin)
{
    std::map<std::string, std::set<std::string>> versions;
    std::map<std::string, int> counts;
    std::map<std::string, std::string> names;  // By the result.
    Value::List stages;
    for (const Value& entry : origin.as_list())
    {
        for (const auto& [library, version] : entry.at("versions").as_map())
            versions[library].insert(version.as_string());
        const std::string& type = entry.at("type").as_string();
        const int count = ++counts[type];
        const std::string name = count == 1 ? type : type + " " + std::to_string(count);
        if (const Value* result = entry.find("result"))
            names[result->as_string()] = name;
        Value::Map inputs;
        for (const auto& [port, input] : entry.at("inputs").as_map())
        {
            const Value* result = input.find("result");
            if (result == nullptr)
                inputs.emplace_back(port, input);
            else if (const auto from = names.find(result->as_string()); from != names.end())
                inputs.emplace_back(port, from->second);
        }
        Value stage = Value::Map{{"stage", name}, {"options", entry.at("options")}, {"inputs", std::move(inputs)}};
        if (const Value* figures = entry.find("figures"))
            stage.set("figures", *figures);
        stages.push_back(std::move(stage));
    }
    Value::Map all;
    for (const auto& [library, several] : versions)
        all.emplace_back(library, fmt::format("{}", fmt::join(several, ", ")));
    return Value::Map{{"versions", std::move(all)}, {"stages", std::move(stages)}};
}

/// Finds the files in a folder that have another name elsewhere.
std::set<std::pair<dev_t, ino_t>> linked_files(const fs::path& folder)
{
    std::set<std::pair<dev_t, ino_t>> files;
    std::error_code error;
    for (const auto& entry : fs::recursive_directory_iterator(folder, error))
        if (const auto status = path_status(entry.path()); status && S_ISREG(status->st_mode) && status->st_nlink > 1)
            files.emplace(status->st_dev, status->st_ino);
    return files;
}

/// The stage of one request, from the lock to the published result.
class StageRun
{
  public:
    StageRun(WorkerRequest request, std::string temporary, WorkerChannel& channel)
        : request_(std::move(request)), temporary_(std::move(temporary)), channel_(channel), store_(request_.store),
          factory_(request_.libraries, request_.key_document.at("libraries")), context_(channel_, store_, request_, temporary_)
    {
    }

    void run()
    {
        forbid_links_below(request_.out, another_out);
        lock_key();
        const std::vector<fs::path> files = each(request_.files, &Dependency::path);
        if (const auto stored = store_.lookup(request_.key, nullptr, files); stored && store_.present(*stored))
            return tell_done(*stored, true);
        channel_.send("running");
        start_ = std::chrono::steady_clock::now();
        verify_inputs();
        factory_.open_all();
        std::unique_ptr<Configurable> object = factory_.make(request_.type);
        // fresco-describe has seen that it is one, as for readers.
        auto& stage = dynamic_cast<Stage&>(*object);
        stage.configure(request_.options, factory_);
        try
        {
            load_inputs(stage);
            origin_ = origin_of(request_, store_, versions());
        }
        catch (const Error&)
        {
            // Damage since they were verified may look like anything.
            verify_inputs();
            throw;
        }
        context_.set_origin(told_origin(origin_));
        umask(mask_);
        run_and_publish(stage);
        // Values may be large, and freeing them helps nobody now.
        (void)object.release();
    }

  private:
    void lock_key()
    {
        const fs::path file = store_.lock_file(request_.key);
        key_lock_ = FileLock(file);
        for (std::string told = "-"; !key_lock_.try_exclusive();)
        {
            // Another may get it before this one.
            if (std::string holder = FileLock::holder_of(file); holder != told)
            {
                channel_.send("waiting", {{"holder", holder}});
                told = std::move(holder);
            }
            context_.check_canceled();
            std::this_thread::sleep_for(std::chrono::milliseconds(200));
        }
        key_lock_.sign();
        store_.look_again();
    }

    void verify_inputs()
    {
        std::set<std::string> referred;
        for (const auto& input : request_.inputs)
        {
            referred.insert(input.references.begin(), input.references.end());
            if (!input.object.empty())
                verify(input.object, input.output);
        }
        for (const auto& object : referred)
            verify(object, "");
    }

    void verify(const std::string& object, const std::string& output)
    {
        context_.check_canceled();
        if (auto damage = store_.verify(object, request_.threads, output))
            throw std::move(*damage);
    }

    /// Verifies the inputs again that share a file with the new result: publish gives it a valid checksum whatever it holds now.
    void verify_linked(const fs::path& made)
    {
        const std::set<std::pair<dev_t, ino_t>> linked = linked_files(made);
        for (const auto& input : request_.inputs)
            if (!input.object.empty() && !linked.empty())
                if (const auto shared = linked_files(store_.object(input.object) / input.output);
                    std::ranges::any_of(shared, [&](const auto& file) { return linked.contains(file); }))
                    verify(input.object, input.output);
    }

    void load_inputs(Stage& stage)
    {
        for (const auto& input : request_.inputs)
        {
            context_.check_canceled();
            const auto& ports = stage.inputs();
            const auto port = std::ranges::find(ports, input.port, &InputPort::name);
            if (port == ports.end())
                throw PluginFailure("the stage has no input " + input.port + ": its plugin changed; run again");
            if (input.object.empty())
            {
                const auto reader = factory_.create(FileReader::component_kind, input.reader);
                (*port)->set(dynamic_cast<FileReader&>(*reader).read(input.file));
            }
            else if (const fs::path folder = store_.object(input.object) / input.output; fs::is_directory(folder))
                (*port)->load({folder, store_.root()});
            else if (!(*port)->is_optional())
                throw MissingInput("input '" + input.port + "' is empty: " + input.from +
                                   " is optional, and that stage made none; its messages say why");
        }
    }

    void run_and_publish(Stage& stage)
    {
        const WorkFolder work(store_, temporary_);
        const fs::path& folder = work.path();
        Publication publication;
        for (OutputPort* output : stage.outputs())
        {
            make_folder(folder / output->name());
            output->set_folder({folder / output->name(), store_.root()});
        }
        fault_point("stage.started");
        run_alone(stage);
        fault_point("stage.done");
        context_.check_canceled();
        for (const OutputPort* output : stage.outputs())
        {
            if (output->is_left_out())
            {
                remove_path(folder / output->name());
                continue;
            }
            output->save();
            publication.outputs.push_back(output->name());
            publication.references.insert(output->references().begin(), output->references().end());
        }
        check_files_unchanged();
        verify_linked(folder);

        publication.key = request_.key;
        publication.dependencies = dependencies();
        publication.facts = facts();
        const StoredResult result = publish(store_, folder, publication);
        store_.remove_checkpoint(request_.key);
        fault_point("publish.done");
        tell_done(result, false);
    }

    /// Runs a stage so that processes it leaves behind cannot write into the published result, and its umask hides nothing.
    void run_alone(Stage& stage)
    {
        try
        {
            stage.run(context_);
        }
        catch (...)
        {
            end_copy();
            throw;
        }
        end_copy();
        end_descendants();
        umask(mask_);
    }

    /// A plugin may fork and return twice.
    void end_copy() const
    {
        if (getpid() != process_)
            std::_Exit(worker_failed);
    }

    /// With the input files, where the stage read others beside them.
    std::vector<Dependency> dependencies()
    {
        std::vector<Dependency> all = context_.settled_dependencies();
        if (!all.empty())
            for (const Dependency& file : request_.files)
                if (std::ranges::find(all, file.path, &Dependency::path) == all.end())
                    all.push_back(file);
        return all;
    }

    void check_files_unchanged()
    {
        for (auto& file : request_.files)
            if (compare(file) == Change::contents)
                throw Error(file.path.string() + ": changed while the stage ran; run again");
    }

    double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }

    Value facts() const
    {
        Value::Map inputs;
        for (const auto& input : request_.inputs)
            inputs.emplace_back(input.port, input.object.empty() ? Value(input.file.string()) : Value(input.object));
        return Value::Map{{"format", 1},
                          {"stage", request_.stage},
                          {"type", request_.type},
                          {"time_s", static_cast<std::int64_t>(std::time(nullptr))},
                          {"seconds", seconds()},
                          {"memory_mb", std::max(peak_memory_mb(), peak_memory_of_programs_mb())},
                          {"threads", request_.threads},
                          {"versions", versions()},
                          {"processor", processor_capability()},
                          {"options", request_.options},
                          {"inputs", Value(std::move(inputs))},
                          {"key_document", request_.key_document},
                          {"report", context_.reported()},
                          {"messages", context_.messages()},
                          {"curves", context_.curves()},
                          {"origin", with_figures(origin_, context_.reported())}};
    }

    Value versions() const
    {
        Value versions = factory_.versions();
        versions.set("fresco", program_version());
        return versions;
    }

    void tell_done(const StoredResult& result, bool stored)
    {
        const Value manifest = store_.manifest(result.object);
        channel_.send("done", {{"object", result.object},
                               {"references", Value::List(result.references.begin(), result.references.end())},
                               {"stored", stored},
                               {"seconds", manifest.at("seconds")},
                               {"memory_mb", manifest.at("memory_mb")},
                               {"disk_mb", static_cast<double>(manifest.at("bytes").as_int()) / (1024.0 * 1024.0)}});
    }

    WorkerRequest request_;
    std::string temporary_;
    WorkerChannel& channel_;
    Store store_;
    const pid_t process_ = getpid();
    const mode_t mask_ = current_mask();  ///< Before any code of a plugin.
    WorkerFactory factory_;
    WorkerContext context_;
    Value origin_;
    FileLock key_lock_;
    std::chrono::steady_clock::time_point start_;
};

}  // namespace

std::string without_folders(std::string_view text)
{
    constexpr std::string_view before = " \t\n=:,;'\"([{<>|";
    for (std::size_t at = 0; at < text.size(); ++at)
    {
        const bool begins = at == 0 || before.find(text[at - 1]) != std::string_view::npos;
        const bool is_home = text.substr(at).starts_with("~");
        const bool is_address =
            at > 0 && text[at - 1] == ':' && text.substr(at).starts_with("//") && !text.substr(0, at).ends_with("file:");
        if (!begins || is_address || !(is_home || text[at] == '/'))
            continue;
        // A path may contain spaces: nobody knows where one ends before the last slash.
        std::size_t last = text.rfind('/');
        if (last == text.size() - 1 && last > at)
            last = text.rfind('/', last - 1);
        if (last == std::string_view::npos || last < at)
            continue;
        return std::string(text.substr(0, at)) + std::string(text.substr(last + 1));
    }
    return std::string(text);
}

Value with_figures(Value origin, const Value& report)
{
    if (Value figures = lasting_entries(report.as_map()); !figures.is_null())
        origin.as_list().back().set("figures", std::move(figures));
    return origin;
}

void run_stage(WorkerRequest request, std::string temporary, WorkerChannel& channel)
{
    StageRun(std::move(request), std::move(temporary), channel).run();
}

}  // namespace fresco::host
