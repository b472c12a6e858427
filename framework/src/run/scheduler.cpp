#include "run/scheduler.h"
#include "base/common.h"
#include "base/machine.h"
#include "base/process.h"
#include "run/running_stage.h"
#include "run/stage_choice.h"
#include "store/presence.h"
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

/// What the stages of one run came to, shown as each ends. One thread.
class RunOutcomes
{
  public:
    /// The display must outlive it.
    explicit RunOutcomes(ProgressDisplay& display) : display_(display) {}

    /// What it took, of a stage whose process ended well.
    void take_figures(const RunningStage& running)
    {
        StageOutcome& outcome = of(running.node());
        outcome.seconds = running.seconds();
        outcome.memory_mb = running.memory_mb();
        outcome.disk_mb = running.disk_mb();
        outcome.threads = running.threads();
    }

    /// Where the figures of any other are put before it ends.
    StageOutcome& of(const StageNode& node) { return outcomes_[node.stage->name]; }

    /// The stage has come to its state: shows it.
    void end(const StageNode& node)
    {
        StageOutcome& outcome = of(node);
        identify(outcome, node);
        if (node.state == StageState::failed)
            outcome.error = stage_error_text(*node.stage, node.error);
        display_.stage_ends(outcome);
    }

    /// Of all stages that were selected, in their order; what failed before it could begin is shown now.
    std::vector<StageOutcome> all(const std::vector<StageNode>& nodes)
    {
        std::vector<StageOutcome> result;
        for (const StageNode& node : nodes)
        {
            if (node.state == StageState::not_selected)
                continue;
            if (node.state == StageState::failed && !outcomes_.contains(node.stage->name))
                end(node);
            StageOutcome outcome = of(node);
            identify(outcome, node);
            result.push_back(std::move(outcome));
        }
        return result;
    }

  private:
    ProgressDisplay& display_;
    std::map<std::string, StageOutcome> outcomes_;
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
        : request_(request), display_(display), store_(request.store),
          upstream_(request.upstream.empty() ? std::nullopt : std::optional<Store>(request.upstream)),
          hashes_(store_.file_index()), state_(make_state()), turns_(request.pipeline->sweep, request.jobs, request.keep_going),
          costs_(store_, request.estimates), standings_(display, costs_, request.out), exporter_(store_, request.out, hashes_),
          outcomes_(display)
    {
    }

    RunSummary run()
    {
        if (enter_store())
        {
            state_.update();
            take_finished();
            for (;;)
            {
                const bool tried = dispatch();
                standings_.show(state_.nodes(), !running_.empty(), request_.cores);
                if (running_.empty() && !tried)
                    break;
                if (running_.empty())
                    continue;  // What could not be started has failed; it is the turn of others.
                wait();
                collect();
                take_finished();
            }
        }
        return summary();
    }

  private:
    RunState make_state()
    {
        const Store* const upstream = upstream_ ? &*upstream_ : nullptr;
        return request_.part ? RunState(*request_.pipeline, store_, hashes_, *request_.part, upstream)
                             : RunState(*request_.pipeline, store_, hashes_, request_.until, upstream);
    }

    bool stopping() const { return stops_ > 0; }

    /// Waits until nobody tidies up the store; false if told to stop before.
    bool enter_store()
    {
        use_.emplace(store_, upstream_ ? &*upstream_ : nullptr);
        const auto begin = Clock::now();
        Backoff backoff;
        for (bool told = false; !use_->try_enter();)
        {
            if (!told && Clock::now() - begin > std::chrono::milliseconds(300))
            {
                const std::string who = use_->tidier();
                display_.note("waiting for 'fresco store gc'" + (who.empty() ? "" : " (" + who + ")") +
                              ", which is cleaning up " + store_.root().string());
                told = true;
            }
            pollfd signals{signals_.descriptor(), POLLIN, 0};
            poll(&signals, 1, static_cast<int>(backoff.next().count()));
            use_->beat();
            display_.tick();
            take_stops();
            if (stopping())
                return false;
        }
        return true;
    }

    /// False where no stage was to be started.
    bool dispatch()
    {
        if (stopping() || request_.only_stored)
            return false;
        Room room{request_.cores, request_.memory_mb};
        for (const auto& running : running_)
            room.take(running.threads(), costs_.expected(running.node()).memory_mb);
        const std::vector<Start> starts = choose_starts(state_, turns_.take(state_.nodes()), costs_, room);
        for (const auto& [node, threads] : starts)
        {
            // Beyond that a process could not be started, or not be spoken to; one that ends gives its own back. A stage
            // that has said nothing yet has its log still to open.
            constexpr int descriptors_of_start = 20;
            if (!running_.empty() && free_descriptors() < descriptors_of_start + static_cast<int>(running_.size()))
                break;
            start(*node, threads);
        }
        return !starts.empty();
    }

    void start(StageNode& node, int threads)
    {
        try
        {
            const WorkerRequest request = make_worker_request(node, state_, store_, request_.out, threads, hashes_);
            const auto limits = request_.limits.find(node.stage->name);
            running_.emplace_back(node, request, store_, limits == request_.limits.end() ? StageLimits{} : limits->second,
                                  display_);
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
        use_->beat();
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
        if (running.result() && end.exit_code == 0 && store_.present(*running.result()))
        {
            node.result = running.result();
            node.present = true;
            node.state = running.was_stored() ? StageState::stored : StageState::done;
            outcomes_.take_figures(running);
            if (!running.was_stored())
                keep_books([&] { costs_.remember(node, {running.seconds(), running.memory_mb(), running.disk_mb()}); });
            outcomes_.end(node);
        }
        else if (!running.not_fetched().empty())
        {
            display_.note(running.not_fetched() + ": stage " + node.stage->name + " runs instead");
            node.state = StageState::waiting;
            node.elsewhere = false;
        }
        else if (running.damage())
            repair(*running.damage(), node);
        else if (running.limit_text().empty() && (running.was_canceled() || (stopping() && end.signal != 0)))
        {
            node.state = StageState::interrupted;
            if (!stopping())
                stop_in_order("stage " + node.stage->name + " was told to stop from outside: stopping");
            outcomes_.of(node).seconds = running.elapsed();
            outcomes_.end(node);
        }
        else
        {
            outcomes_.of(node).seconds = running.elapsed();
            fail(node, failure_text(running, request_.pipeline->file, store_.root()), failure_code(running));
            end_orphans();
        }
        state_.update(node);
    }

    void end_orphans() const
    {
        const std::vector<pid_t> own = each<pid_t>(running_, [&](const auto& running) { return running.process(); });
        orphans_.end(own);
    }

    /// What is written about results, not the results: no run ends because there is no room for it.
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
        outcomes_.end(node);
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
            exporter_.copy(*node.stage, node.result->object,
                           [this]
                           {
                               take_stops();
                               use_->beat();
                               return stopping();
                           });
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
            if (node.state == StageState::waiting && !stopping() && !turns_.ended_early() && !request_.only_stored)
                throw std::logic_error("the stage " + node.stage->name + " was never started");
        // Its key leads to what was made from it, also after a clean-up.
        for (const auto& node : state_.nodes())
            if (node.state == StageState::not_needed && node.may_run && node.result)
                record(node);
        RunSummary result;
        result.stages = outcomes_.all(state_.nodes());
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
    std::optional<Store> upstream_;
    std::optional<StoreUse> use_;
    FileHashes hashes_;
    RunState state_;
    SweepTurns turns_;
    StageCosts costs_;
    StageStandings standings_;
    Exporter exporter_;
    StopSignals signals_;
    Orphans orphans_;
    std::list<RunningStage> running_;
    RunOutcomes outcomes_;
    std::map<std::string, std::string> taken_;
    std::map<std::string, int> repairs_;
    int stops_ = 0;
    Clock::time_point stop_deadline_;
};

}  // namespace

void identify(StageOutcome& outcome, const StageNode& node)
{
    outcome.stage = node.stage->name;
    outcome.type = node.stage->type->type;
    outcome.state = node.state == StageState::waiting ? StageState::blocked : node.state;
    outcome.key = node.key;
    outcome.object = node.present && node.result ? node.result->object : "";
}

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
    set_input_roots(request.pipeline->inputs);
    forbid_links_below(request.out, another_out);
    Scheduler scheduler(request, display);
    return scheduler.run();
}

}  // namespace fresco::host
