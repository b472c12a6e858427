#include "run/scheduler.h"
#include "base/common.h"
#include "base/machine.h"
#include "base/process.h"
#include "base/text.h"
#include "plugins/plugin_library.h"
#include "run/running_stage.h"
#include "run/stage_choice.h"
#include "store/stage_record.h"
#include "store/store_tidy.h"
#include "worker/worker.h"
#include <fresco/error.h>
#include <fresco/file_access.h>

#include <algorithm>
#include <csignal>
#include <list>
#include <poll.h>
#include <stdexcept>
#include <sys/signalfd.h>
#include <unistd.h>
#include <utility>

namespace fresco::host
{

namespace
{
/// While it lives, SIGINT, SIGTERM, SIGHUP and SIGCHLD arrive as a readable descriptor instead of interrupting anything.
class StopSignals
{
  public:
    StopSignals()
    {
        sigset_t taken;
        sigemptyset(&taken);
        for (const int number : {SIGINT, SIGTERM, SIGCHLD})
            sigaddset(&taken, number);
        // Under nohup it stays ignored.
        struct sigaction hangup = {};
        if (sigaction(SIGHUP, nullptr, &hangup) == 0 && hangup.sa_handler != SIG_IGN)
            sigaddset(&taken, SIGHUP);
        sigprocmask(SIG_BLOCK, &taken, &before_);
        fd_ = FileDescriptor(signalfd(-1, &taken, SFD_CLOEXEC | SFD_NONBLOCK));
        if (!fd_.valid())
            throw Error("cannot handle signals: no file descriptor left");
    }

    ~StopSignals()
    {
        take();
        // A scheduler may repeat it while the process writes its last files.
        if (told_to_end_)
            for (const int number : {SIGTERM, SIGHUP})
                std::signal(number, SIG_IGN);
        sigprocmask(SIG_SETMASK, &before_, nullptr);
    }

    StopSignals(const StopSignals&) = delete;
    StopSignals& operator=(const StopSignals&) = delete;

    int descriptor() const { return fd_.get(); }
    /// How many requests to stop (SIGINT, SIGTERM, SIGHUP) came since the last call. All but the first SIGTERM or SIGHUP do not
    /// count: schedulers send one to each process of a job, and job scripts pass theirs on.
    int take()
    {
        int stops = 0;
        signalfd_siginfo info{};
        while (read(fd_.get(), &info, sizeof info) == static_cast<ssize_t>(sizeof info))
        {
            const bool asked = info.ssi_signo == SIGINT;
            const bool told = info.ssi_signo == SIGTERM || info.ssi_signo == SIGHUP;
            stops += asked || (told && !std::exchange(told_to_end_, true)) ? 1 : 0;
        }
        return stops;
    }

  private:
    sigset_t before_{};
    FileDescriptor fd_;
    bool told_to_end_ = false;
};

/// The exit code for what failed, 0 if nothing did. That a stage itself failed counts for more than that an input was missing.
int exit_code_of(const std::vector<StageNode>& nodes)
{
    int code = 0;
    for (const StageNode& node : nodes)
        if (node.state == StageState::failed)
            code = code == 0 || node.error_code == worker_failed ? node.error_code : code;
    return code;
}

using Clock = std::chrono::steady_clock;
constexpr auto stop_patience = std::chrono::seconds(8);
constexpr int repairs_per_result = 2;

class Scheduler
{
  public:
    Scheduler(const RunRequest& request, ProgressDisplay& display)
        : request_(request), display_(display), store_(request.store), hashes_(store_.file_index()),
          state_(*request.pipeline, store_, hashes_, request.until, request.part ? &*request.part : nullptr),
          turns_(request.pipeline->sweep, request.jobs, request.keep_going), expected_(store_),
          exporter_(store_, *request.pipeline, request.out, hashes_, request.replace)
    {
        if (adopts_)
            adopt_orphans();
    }

    RunSummary run()
    {
        if (enter_store())
        {
            state_.update();
            check_outputs();
            take_finished();
            open_plugins();
            for (;;)
            {
                const bool tried = dispatch();
                show_states();
                if (running_.empty() && !tried)
                    break;
                if (running_.empty())
                    continue;  // Stages that could not be started have failed; others follow.
                wait();
                collect();
                take_finished();
            }
        }
        return summary();
    }

  private:
    bool stopping() const { return stops_ > 0; }

    /// Waits until nobody tidies up the store; false if told to stop before.
    bool enter_store()
    {
        for (int tries = 0; !host::enter_store(store_, in_use_); ++tries)
        {
            if (tries == 1)
            {
                const std::string who = FileLock::holder_of(store_.lock_file("store"));
                display_.note("waiting for 'fresco store gc'" + (who.empty() ? "" : " (" + who + ")") +
                              ", which is cleaning up " + store_.root().string());
            }
            pollfd signals{signals_.descriptor(), POLLIN, 0};
            poll(&signals, 1, 300);
            display_.tick();
            take_stops();
            if (stopping())
                return false;
        }
        return true;
    }

    void protect_inputs(const StoredResult& result)
    {
        for (const Dependency& dependency : result.dependencies)
            if (!dependency.folder)
                exporter_.protect(dependency.path);
    }

    /// Throws Error where a file that fresco may not replace lies in the place of an output: before anything runs.
    void check_outputs()
    {
        std::vector<std::string> found;
        for (const StageNode& node : state_.nodes())
            if (node.result)
                protect_inputs(*node.result);
        for (const StageNode& node : state_.nodes())
        {
            if (node.exports_files && node.selected)
                for (std::string& text : exporter_.obstacles(*node.stage, node.present ? node.result->object : ""))
                    found.push_back(std::move(text));
            const fs::path pictures = preview_folder(request_.out, *node.stage);
            const auto there = node.state == StageState::waiting ? entries_of(pictures) : std::vector<fs::path>{};
            if (!there.empty() && !request_.replace && !path_status(pictures / progress_mark))
                found.push_back(pictures.string() +
                                ": fresco shows the running stage there, but the folder has files that it did not write; " +
                                obstacle_advice);
            for (const fs::path& picture : there)
                if (exporter_.is_input(picture))
                    found.push_back(picture.string() + ": " + input_obstacle);
        }
        refuse_obstacles(found);
    }

    /// Tries all plugins that the run needs, before hours of work. Stages whose plugins cannot be opened fail, and none begins.
    void open_plugins()
    {
        const auto libraries_of = [](const StageNode& node)
        {
            std::set<fs::path> libraries{node.stage->type->library};
            for (const TypeDescription* component : node.stage->components)
                libraries.insert(component->library);
            return libraries;
        };
        std::set<fs::path> needed;
        for (const StageNode& node : state_.nodes())
            if (node.state == StageState::waiting && !request_.only_stored)
                needed.merge(libraries_of(node));
        for (const Refusal& refusal : refused_when_opened(needed))
        {
            has_unusable_plugins_ = true;
            for (StageNode& node : state_.nodes())
                if (node.state == StageState::waiting && libraries_of(node).contains(refusal.library))
                    fail(node, "plugin " + refusal.library.string() + ": " + refusal.reason, worker_plugin);
        }
    }

    /// False where no stage was to be started.
    bool dispatch()
    {
        if (stopping() || request_.only_stored || has_unusable_plugins_)
            return false;
        Room room{request_.cores, request_.memory_mb};
        for (const auto& running : running_)
            room.take(running.threads(), expected_.memory_mb(running.node()));
        const std::vector<Start> starts = choose_starts(state_, turns_.take(state_.nodes()), expected_, room);
        for (const auto& [node, threads] : starts)
            start(*node, threads);
        return !starts.empty();
    }

    void start(StageNode& node, int threads)
    {
        try
        {
            const Value request = make_worker_request(node, state_, store_, request_.out, threads, hashes_);
            running_.emplace_back(node, request, store_, request_.limits, display_);
            node.state = StageState::running;
            state_.update(node);
            link_stage_log(store_, request_.pipeline->file, node.stage->name, node.key);
        }
        catch (const MissingInput& error)
        {
            fail(node, error.what(), worker_missing_input);
        }
        catch (const Error& error)
        {
            fail(node, error.what(), worker_failed);
        }
    }

    /// Shows the stages whose state has changed. There may be thousands: while some are running, ten times a second at most.
    void show_states()
    {
        if (!running_.empty() && Clock::now() - last_shown_ < std::chrono::milliseconds(100))
            return;
        last_shown_ = Clock::now();
        const std::vector<StageNode>& nodes = state_.nodes();
        shown_.resize(nodes.size());
        std::vector<StageStanding> changed;
        for (std::size_t i = 0; i < nodes.size(); ++i)
            if (const StageNode& node = nodes[i]; std::exchange(shown_[i], node.state) != node.state)
                changed.push_back({node.stage->name, node.state, expected_.measured(node).value_or(Usage{}).seconds,
                                   preview_folder(request_.out, *node.stage)});
        if (!changed.empty())
            display_.stages(changed, request_.cores);
    }

    void wait()
    {
        std::vector<pollfd> descriptors{{signals_.descriptor(), POLLIN, 0}};
        for (const auto& running : running_)
        {
            descriptors.push_back({running.event_descriptor(), POLLIN, 0});
            descriptors.push_back({running.output_descriptor(), POLLIN, 0});
        }
        poll(descriptors.data(), descriptors.size(), 200);
        for (auto& running : running_)
            running.hold_to_limits();
        // A stream at its end is readable all the time; the process's end follows within a moment.
        const bool hung_up = std::any_of(descriptors.begin() + 1, descriptors.end(),
                                         [](const pollfd& entry) { return (entry.revents & POLLHUP) != 0; });
        if (hung_up)
            poll(descriptors.data(), 1, 5);
        take_stops();
        display_.tick();
    }

    void take_stops()
    {
        const int more = signals_.take();
        if (more == 0)
        {
            if (stopping() && Clock::now() > stop_deadline_)
                stop_all(SIGKILL);
            return;
        }
        if (stopping() || more > 1)
        {
            stops_ += more;
            stop_all(SIGKILL);
        }
        else
            stop_in_order("stopping; press Ctrl-C again to stop at once");
    }

    /// The first request to stop: everyone may come to a good place, within the patience.
    void stop_in_order(const std::string& note)
    {
        display_.note(note);
        stops_ = 1;
        stop_deadline_ = Clock::now() + stop_patience;
        stop_all(SIGTERM);
    }

    void stop_all(int signal)
    {
        for (const auto& running : running_)
            running.stop(signal);
    }

    void collect()
    {
        for (auto entry = running_.begin(); entry != running_.end();)
        {
            entry->take_events();
            if (!entry->ended())
            {
                ++entry;
                continue;
            }
            finish(*entry);
            entry = running_.erase(entry);
        }
    }

    void finish(RunningStage& running)
    {
        StageNode& node = running.node();
        const ProcessEnd& end = running.end();
        const StageAnswer& answer = running.answer();
        if (answer.result && end.exit_code == 0 && store_.present(*answer.result))
        {
            node.result = answer.result;
            node.present = true;
            node.state = answer.was_stored ? StageState::stored : StageState::done;
            node.took = answer.took;
            node.threads = running.threads();
            if (!answer.was_stored)
                keep_books([&] { expected_.remember(node, answer.took); });
            show_end(node);
        }
        else if (answer.damage)
            repair(*answer.damage, node);
        else if (!running.exceeded_limit() && (answer.was_canceled || (stopping() && end.signal != 0)))
        {
            node.state = StageState::interrupted;
            if (!stopping())
                stop_in_order("stage " + node.stage->name + " was told to stop from outside: stopping");
            node.took.seconds = running.elapsed();
            show_end(node);
        }
        else
        {
            node.took.seconds = running.elapsed();
            fail(node, running.failure_text(request_.pipeline->file), running.failure_code());
            // A process that crashed left them behind.
            if (adopts_)
                end_descendants(each(running_, &RunningStage::process));
        }
        state_.update(node);
    }

    /// How the stage and its result stand at the end of a run; one that still waits is blocked.
    static StageOutcome outcome(const StageNode& node)
    {
        return {node.stage->name,
                node.stage->type->type,
                node.state == StageState::waiting ? StageState::blocked : node.state,
                node.key,
                node.present && node.result ? node.result->object : "",
                node.took.seconds,
                node.took.memory_mb,
                node.took.disk_mb,
                node.threads,
                node.state == StageState::failed ? stage_error_text(*node.stage, node.error) : node.error};
    }

    void show_end(const StageNode& node)
    {
        ended_.insert(&node);
        display_.stage_ends(outcome(node));
    }

    /// Writes records about results. A full disk does not end the run: the results are whole without them.
    template <class Write>
    void keep_books(const Write& write)
    {
        try
        {
            write();
        }
        catch (const std::runtime_error& error)
        {
            display_.note(std::string(error.what()) + "; the run goes on without this record");
        }
    }

    /// A damaged result is removed, unless another run was faster; whoever makes it runs again.
    void repair(const Damage& damage, StageNode& reader)
    {
        reader.state = StageState::waiting;
        if (++repairs_[damage.object] > repairs_per_result)
        {
            fail(reader, repeated_damage_text(damage, state_), worker_failed);
            return;
        }
        try
        {
            const bool removed = discard_damaged(store_, damage.object, request_.cores);
            display_.note(damage.text + ": the result " +
                          (removed ? "is damaged and is recomputed" : "was damaged; another run has since recomputed it"));
        }
        catch (const Error& error)
        {
            fail(reader, error.what(), worker_failed);
        }
        state_.update();
    }

    void fail(StageNode& node, const std::string& text, int code)
    {
        node.state = StageState::failed;
        node.error = text;
        node.error_code = code;
        show_end(node);
        state_.update(node);
    }

    /// Records and exports results that are there, whether they were made now or before.
    void take_finished()
    {
        for (auto places = state_.take_arrived(); !places.empty(); places = state_.take_arrived())
            for (const std::size_t place : places)
                take(state_.nodes()[place]);
    }

    void take(StageNode& node)
    {
        const bool there = node.state == StageState::done || node.state == StageState::stored;
        if (!there || !node.may_run || taken_[node.stage->name] == node.result->object)
            return;
        taken_[node.stage->name] = node.result->object;
        // A worker reports only the object; the manifest has its dependencies.
        if (const auto made = attempt([&] { return result_of(node.result->object, store_.manifest(node.result->object)); }))
            protect_inputs(*made);
        link_stage_log(store_, request_.pipeline->file, node.stage->name, node.key);
        record(node);
        if (node.exports_files && !stopping())
            export_result(node);
    }

    void record(const StageNode& node)
    {
        keep_books(
            [&] {
                write_stage_record(store_, request_.pipeline->file,
                                   {node.stage->name, node.key, node.result->object, node.key_document});
            });
    }

    void export_result(StageNode& node)
    {
        const std::size_t before = exporter_.files().size();
        try
        {
            const std::size_t removed = exporter_.copy(*node.stage, node.result->object,
                                                       [this]
                                                       {
                                                           take_stops();
                                                           return stopping();
                                                       });
            if (removed > 0)
                display_.note(node.stage->name + ": removed " + counted(removed, "file") +
                              " of the last run that it no longer writes");
            for (std::size_t i = before; i < exporter_.files().size(); ++i)
                display_.exported(node.stage->name, exporter_.files()[i].path, exporter_.files()[i].written);
        }
        catch (const Damage& damage)
        {
            taken_.erase(node.stage->name);
            repair(damage, node);
        }
        catch (const Error& error)
        {
            fail(node, error.what(), worker_failed);
        }
    }

    RunSummary summary()
    {
        for (const auto& node : state_.nodes())
            if (node.state == StageState::waiting && !stopping() && !turns_.ended_early() && !request_.only_stored &&
                !has_unusable_plugins_)
                throw std::logic_error("the stage " + node.stage->name + " was never started");
        // Its key leads to what was made from it, also after a clean-up.
        for (const auto& node : state_.nodes())
            if (node.state == StageState::not_needed && node.may_run && node.result)
                record(node);
        RunSummary result;
        for (const auto& node : state_.nodes())
        {
            if (node.state == StageState::not_selected)
                continue;
            // A stage that failed before it could begin has not been shown.
            if (node.state == StageState::failed && !ended_.contains(&node))
                show_end(node);
            result.stages.push_back(outcome(node));
        }
        result.files = exporter_.files();
        result.exit_code = stopping() ? int{worker_canceled} : exit_code_of(state_.nodes());
        const bool whole =
            request_.until.empty() && !request_.part && !request_.only_stored && !request_.pipeline->sweep.narrowed;
        if (whole && result.exit_code == 0)
        {
            std::set<std::string> stages;
            for (const PipelineStage& stage : request_.pipeline->stages)
                stages.insert(stage.name);
            remove_old_records(store_, request_.pipeline->file, stages);
        }
        hashes_.save();
        return result;
    }

    const RunRequest& request_;
    ProgressDisplay& display_;
    Store store_;
    FileLock in_use_ = store_lock(store_);
    FileHashes hashes_;
    RunState state_;
    SweepTurns turns_;
    Expectations expected_;
    Exporter exporter_;
    StopSignals signals_;
    const bool adopts_ = children_of(getpid()).empty();  ///< Others' orphans would look like those of stages.
    std::list<RunningStage> running_;
    std::set<const StageNode*> ended_;
    std::vector<std::optional<StageState>> shown_;
    Clock::time_point last_shown_;
    std::map<std::string, std::string> taken_;
    std::map<std::string, int> repairs_;
    bool has_unusable_plugins_ = false;
    int stops_ = 0;
    Clock::time_point stop_deadline_;
};

}  // namespace

const StageOutcome* RunSummary::outcome_of(const std::string& stage) const
{
    if (places_.size() != stages.size())
        for (std::size_t i = 0; i < stages.size(); ++i)
            places_[stages[i].stage] = i;
    const auto found = places_.find(stage);
    return found == places_.end() ? nullptr : &stages[found->second];
}

RunSummary run_pipeline(const RunRequest& request, ProgressDisplay& display)
{
    forbid_links_below(request.out, another_out);
    Scheduler scheduler(request, display);
    return scheduler.run();
}

}  // namespace fresco::host
