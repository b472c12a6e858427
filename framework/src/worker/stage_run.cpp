#include "worker/stage_run.h"
#include "base/fault.h"
#include "base/machine.h"
#include "base/process.h"
#include "store/publish.h"
#include "store/store_copy.h"
#include "worker/origin.h"
#include "worker/worker_context.h"
#include "worker/worker_factory.h"
#include <fresco/error.h>
#include <fresco/process.h>
#include <fresco/reader.h>
#include <fresco/stage.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <memory>
#include <set>
#include <sys/stat.h>
#include <thread>
#include <unistd.h>

namespace fresco::host
{
namespace fs = std::filesystem;
namespace
{

std::vector<fs::path> paths_of(const std::vector<Dependency>& files)
{
    std::vector<fs::path> paths;
    for (const Dependency& file : files)
        paths.push_back(file.path);
    return paths;
}

/// The stage of one request, from the lock to the published result.
class StageRun
{
  public:
    StageRun(WorkerRequest request, std::string temporary, WorkerChannel& channel)
        : request_(std::move(request)), temporary_(std::move(temporary)), channel_(channel), store_(request_.store),
          input_files_(paths_of(request_.files)), factory_(request_.libraries, request_.key_document.at("libraries")),
          context_(channel_, store_, request_.key, temporary_, request_.preview_folder, request_.threads, input_files_,
                   computing_place(request_.options))
    {
    }

    void run()
    {
        forbid_links_below(request_.out, another_out);
        lock_key();
        if (const auto stored = store_.lookup(request_.key, nullptr, input_files_); stored && store_.present(*stored))
        {
            tell_done(*stored, true);
            return;
        }
        if (!request_.fetch.empty())
            return fetch();
        channel_.send("running");
        start_ = std::chrono::steady_clock::now();
        verify_inputs();
        factory_.open_all();
        std::unique_ptr<Configurable> object = factory_.make(request_.type, "stage");
        auto* stage = dynamic_cast<Stage*>(object.get());
        if (stage == nullptr)
            throw PluginFailure("plugin " + request_.libraries.at(request_.type).string() + ": " + request_.type +
                                " is not a stage");
        stage->configure(request_.options, factory_);
        try
        {
            load_inputs(*stage);
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
        folder_ = store_.make_temporary(temporary_);
        try
        {
            run_and_publish(*stage);
        }
        catch (...)
        {
            remove_quietly(folder_);
            throw;
        }
        // Values may be large, and freeing them helps nobody now.
        (void)object.release();
    }

  private:
    void lock_key()
    {
        const fs::path file = store_.lock_file(request_.key);
        key_lock_ = FileLock(file);
        Backoff backoff;
        for (std::string told = "-"; !key_lock_.try_exclusive();)
        {
            // Another may get it before this one.
            if (std::string holder = FileLock::holder_of(file); holder != told)
            {
                channel_.send("waiting", {{"holder", holder}});
                told = std::move(holder);
            }
            const auto end = std::chrono::steady_clock::now() + backoff.next();
            while (std::chrono::steady_clock::now() < end)
            {
                context_.check_canceled();
                std::this_thread::sleep_for(std::chrono::milliseconds(50));
            }
        }
        key_lock_.sign();
        store_.look_again();
    }

    void fetch()
    {
        CopiedResults done;
        try
        {
            if (copy_result(
                    Store(request_.upstream), store_, request_.fetch, [this] { context_.check_canceled(); }, done))
            {
                channel_.send("message", {{"text", "copied from " + request_.upstream.string()}});
                return tell_done(result_of(request_.fetch, store_.manifest(request_.fetch)), true);
            }
        }
        catch (const Error& error)
        {
            done.damages.push_back({request_.fetch, error.what()});
        }
        channel_.send("not_fetched", {{"text", done.damages.front().text}});
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
            throw DamagedInput{std::move(*damage)};
    }

    void load_inputs(Stage& stage)
    {
        for (const auto& input : request_.inputs)
        {
            context_.check_canceled();
            const auto& ports = stage.inputs();
            const auto port = std::find_if(ports.begin(), ports.end(),
                                           [&](const InputPort* candidate) { return candidate->name() == input.port; });
            if (port == ports.end())
                throw PluginFailure("the stage has no input " + input.port + ": its plugin changed; run again");
            if (input.object.empty())
            {
                const auto reader =
                    std::dynamic_pointer_cast<FileReader>(factory_.create(FileReader::component_kind, input.reader));
                if (reader == nullptr)
                    throw PluginFailure(input.reader.at("type").as_string() + " is not a reader");
                (*port)->set(reader->read(input.file));
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
        Publication publication;
        for (OutputPort* output : stage.outputs())
        {
            make_folder(folder_ / output->name());
            output->set_folder({folder_ / output->name(), store_.root()});
        }
        fault_point("stage.started");
        run_alone(stage);
        fault_point("stage.done");
        context_.check_canceled();
        for (const OutputPort* output : stage.outputs())
        {
            if (output->is_left_out())
            {
                remove_path(folder_ / output->name());
                continue;
            }
            output->save();
            publication.outputs.push_back(output->name());
            publication.references.insert(output->references().begin(), output->references().end());
        }
        check_files_unchanged();

        publication.key = request_.key;
        publication.dependencies = dependencies();
        publication.facts = facts();
        const StoredResult result = publish(store_, folder_, publication);
        store_.remove_checkpoint(request_.key);
        fault_point("publish.done");
        tell_done(result, false);
    }

    /// Nothing that the stage leaves behind may write into what is published, nor what it does to the mask hide that from others.
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
                if (std::none_of(all.begin(), all.end(), [&](const Dependency& other) { return other.path == file.path; }))
                    all.push_back(file);
        for (Dependency& dependency : all)
            dependency.name = input_name(dependency.path);
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
    std::vector<fs::path> input_files_;
    const pid_t process_ = getpid();
    const mode_t mask_ = current_mask();  ///< Before any code of a plugin.
    WorkerFactory factory_;
    WorkerContext context_;
    Value origin_;
    FileLock key_lock_;
    fs::path folder_;
    std::chrono::steady_clock::time_point start_;
};

}  // namespace

void run_stage(WorkerRequest request, std::string temporary, WorkerChannel& channel)
{
    StageRun(std::move(request), std::move(temporary), channel).run();
}

}  // namespace fresco::host
