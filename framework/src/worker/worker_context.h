#pragma once

#include "worker/worker.h"
#include <fresco/run_context.h>
#include <fresco/value.h>

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

/// \file What a stage sees of its run (RunContext), and the channel by which the host hears of it.

namespace fresco::host
{

/// The worker's side of the channel to the host: one JSON line per event. Thread-safe.
class WorkerChannel
{
  public:
    /// Sends an event. If the host no longer listens, the process is asked to stop.
    void send(std::string_view event, Value::Map entries = {});

  private:
    std::mutex mutex_;
};

/// From now on SIGTERM, SIGINT and SIGHUP ask this process to stop instead of ending it.
void take_stop_signals();

/// How the running figures of a stage went, from what it says with metric and progress; thinned evenly where there are many
/// points.
class MetricCurves
{
  public:
    static constexpr std::size_t most_points = 600;  ///< Beyond that, every second one goes.

    struct Point
    {
        double done = 0;
        Value metrics;  ///< Name -> number, or null where it was not finite.
    };

    /// The figures at `done`. Where a stage goes back to an earlier place, what was there goes. True if the point was kept.
    bool add(double done, const Value& metrics);
    /// {unit, done: [...], metrics: {name: [...]}}, null where a figure was not known yet; null if nothing was reported.
    Value to_value(std::string_view unit) const;
    const std::vector<Point>& points() const { return points_; }

  private:
    void thin();

    std::vector<Point> points_;
    double least_step_ = 0;
};

/// The host, as a running stage sees it: talks to it over the channel, and keeps entries of the manifest.
class WorkerContext final : public RunContext
{
  public:
    /// `temporary`: how the names of temporary folders begin. All but that must outlive it.
    WorkerContext(WorkerChannel& channel, const Store& store, const WorkerRequest& request, std::string temporary);
    ~WorkerContext() override;

    void progress(double done, double total, std::string_view unit) override;
    void check_canceled() const override;
    int threads() const override { return request_.threads; }
    void message(std::string_view text) override { say("message", text); }
    void warning(std::string_view text) override { say("warning", text); }
    void metric(std::string_view name, double value) override;
    void report(std::string_view key, Value value) override;
    Value origin() const override { return origin_; }
    std::filesystem::path preview_folder() override;
    std::filesystem::path scratch_folder() override;
    std::filesystem::path checkpoint_folder() override;
    void reads_file(const std::filesystem::path& file) override { depend_on(file, false); }
    using RunContext::reads_folder;
    void reads_folder(const std::filesystem::path& folder, std::string_view names) override;

    /// Before the stage runs: what origin() returns.
    void set_origin(Value origin) { origin_ = std::move(origin); }
    /// Everything reads_file and reads_folder named, sorted by path. Throws Error if any of it changed meanwhile.
    std::vector<Dependency> settled_dependencies();
    const Value& reported() const { return report_; }
    const Value& messages() const { return messages_; }
    /// How the stage's metrics went, see MetricCurves::to_value.
    Value curves() const { return curves_.to_value(curve_unit_); }

  private:
    void say(std::string_view event, std::string_view text);
    void depend_on(const std::filesystem::path& path, bool folder);
    void keep_curves(double done, std::string_view unit);
    void keep_checkpoint_share();
    bool checkpoint_fits(const std::string& key) const;
    Value input_file_names() const;
    void record_dependencies() const;
    void drop_unfit_checkpoint();
    void take_over_checkpoint() const;

    WorkerChannel& channel_;
    const Store& store_;
    const WorkerRequest& request_;
    const std::string& key_;
    std::string temporary_;
    Value place_;  ///< See computing_place.
    std::mutex mutex_;
    std::filesystem::path scratch_;
    bool checkpointing_ = false;
    std::int64_t checkpoint_time_ = 0;  ///< When its folder changed last.
    double done_share_ = 0;             ///< By the last progress.
    /// By path, and whether it is a pattern of names.
    std::map<std::pair<std::filesystem::path, bool>, Dependency> dependencies_;
    Value origin_{Value::Map{}};
    Value report_{Value::Map{}};
    Value messages_{Value::List{}};
    Value metrics_{Value::Map{}};
    bool metrics_changed_ = false;
    MetricCurves curves_;
    std::string curve_unit_;
    std::chrono::steady_clock::time_point next_progress_;
};

}  // namespace fresco::host
