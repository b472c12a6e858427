#pragma once

#include "store/store.h"
#include <fresco/value.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace fresco::host
{

constexpr const char* report_name = "report.html";

struct ReportInput
{
    std::string port;
    std::string artifact;
    std::string from_stage;  ///< Empty: a file.
    std::string from_port;
    std::string file;
};

struct ReportOutput
{
    std::string name;
    std::string artifact;
};

struct ReportStage
{
    std::string name;
    std::string type;
    std::string help;
    std::string state;   ///< to_string(StageState)
    double seconds = 0;  ///< In this run; of a stored result: when it was made.
    double memory_mb = 0;
    double disk_mb = 0;
    std::string error;
    std::string object;  ///< Empty: there is no result.
    std::vector<ReportInput> inputs;
    std::vector<ReportOutput> outputs;
    Value options{Value::Map{}};
    Value report{Value::Map{}};
    Value messages{Value::List{}};
    Value curves;

    bool ran() const { return state == "ran" || state == "failed" || state == "interrupted"; }
};

struct ReportFile
{
    std::string stage;
    std::string name;  ///< Below the folder of results.
    std::uintmax_t bytes = 0;
};

/// What a report says in words and figures.
struct ReportModel
{
    std::string pipeline;  ///< Name of the file.
    std::filesystem::path store;
    std::filesystem::path out;
    std::string program;  ///< "fresco 0.1.0"
    std::string processor;
    std::string time;  ///< "2024-05-31 12:34 UTC"
    std::string signature;
    std::string outcome;  ///< "done", "failed", "interrupted", "not finished"
    int cores = 1;
    double seconds = 0;
    std::vector<ReportStage> stages;  ///< In a topological order.
    std::vector<ReportFile> files;
};

/// The model from what the host wrote for its child, with the stages' own reports from the store; a manifest that cannot be read
/// leaves its stage's report empty.
ReportModel report_model(const Value& request);

/// A camera picture and what was rendered from the same place.
struct ReportView
{
    std::string name;
    std::string camera;  ///< Data URIs.
    std::string render;
    Value pose;  ///< {position, forward, up}: three numbers each, in the world of the room.
};

struct ReportPicture
{
    std::string name;
    std::string uri;
    bool video = false;
};

/// The textured mesh, small enough for a page.
struct ReportRoom
{
    std::string stage;
    std::size_t vertices = 0;
    std::size_t triangles = 0;
    std::array<double, 3> low{};     ///< World position of (0, 0, 0).
    std::array<double, 3> extent{};  ///< World size of the range 0..65535.
    std::string geometry;            ///< Base64 of what room_geometry packs.
    std::string texture;             ///< Data URI.
    Value start;                     ///< A pose as of ReportView, and `looking`: the mean of all views' directions. Or null.
};

/// What there is to look at.
struct ReportMedia
{
    std::vector<ReportView> views;
    std::vector<ReportRoom> room;  ///< One or none.
    std::vector<ReportPicture> atlas;
    std::vector<ReportPicture> pictures;
    std::vector<std::string> notes;  ///< What is missing, and why.
};

/// The page: one HTML file that fetches nothing.
std::string report_page(const ReportModel& model, const ReportMedia& media);

/// With what every page begins.
constexpr std::string_view report_begin = "<!doctype html><!-- fresco report ";

/// The first line of a page with this signature.
std::string report_mark(const std::string& signature);

}  // namespace fresco::host
