#pragma once

#include "worker/metric_curves.h"
#include "worker/worker_channel.h"

#include "store/store.h"
#include <fresco/run_context.h>

#include <chrono>
#include <map>
#include <mutex>

namespace fresco::host
{

/// What a running stage sees of the host: speaks to it over the channel, keeps what goes into the manifest.
class WorkerContext final : public RunContext
{
  public:
    /// `temporary`: how the names of temporary folders begin. `place`: see computing_place.
    WorkerContext(WorkerChannel& channel, const Store& store, std::string key, std::string temporary,
                  std::filesystem::path preview_folder, int threads, std::vector<std::filesystem::path> input_files, Value place);
    ~WorkerContext() override;

    void progress(double done, double total, std::string_view unit) override;
    void check_canceled() const override;
    int threads() const override { return threads_; }
    void message(std::string_view text) override;
    void warning(std::string_view text) override;
    void metric(std::string_view name, double value) override;
    void report(std::string_view key, Value value) override;
    Value origin() const override { return origin_; }
    std::filesystem::path preview_folder() override;
    std::filesystem::path scratch_folder() override;
    std::filesystem::path checkpoint_folder() override;
    void reads_file(const std::filesystem::path& file) override;
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
    bool checkpoint_fits() const;
    Value input_file_names() const;
    void record_dependencies() const;
    void drop_unfit_checkpoint();

    WorkerChannel& channel_;
    const Store& store_;
    std::string key_;
    std::string temporary_;
    std::filesystem::path preview_folder_;
    int threads_;
    std::mutex mutex_;
    std::filesystem::path scratch_;
    bool checkpointing_ = false;
    std::int64_t checkpoint_time_ = 0;  ///< When its folder changed last.
    double done_share_ = 0;             ///< By the last progress.
    std::vector<std::filesystem::path> input_files_;
    Value place_;
    std::map<std::pair<std::filesystem::path, bool>, Dependency>
        dependencies_;  ///< By path, and whether it is a pattern of names.
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
