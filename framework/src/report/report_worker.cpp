#include "report/page_child.h"
#include "report/report_media.h"
#include "report/report_model.h"

#include "report/report.h"
#include <fresco/files_io.h>

namespace fresco::host
{
namespace
{

ReportMedia media_of(const ReportModel& model, const Value& images)
{
    if (!images.is_null())
        return report_media(model, *image_codec(images));
    ReportMedia nothing;
    nothing.notes.emplace_back("There are no pictures: no plugin reads and writes them (image.opencv)");
    return nothing;
}

}  // namespace

int internal_report(const std::filesystem::path& request_file)
{
    return serve_page(request_file,
                      [](const Value& request)
                      {
                          const ReportModel model = report_model(request);
                          write_file(model.out / report_name, report_page(model, media_of(model, request.at("images"))));
                      });
}

}  // namespace fresco::host
