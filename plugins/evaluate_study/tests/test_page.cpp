#include "catch.h"
#include "page.h"
#include "small_study.h"

#include <fresco/value.h>

using namespace study;

namespace
{

/// The data in the page, as its script reads it.
fresco::Value data_of(const std::string& text)
{
    const std::string_view mark = "id=\"study-data\">";
    const auto begin = text.find(mark) + mark.size();
    return fresco::parse_json(std::string_view(text).substr(begin, text.find("</script>", begin) - begin));
}

}  // namespace

TEST_CASE("the page holds the pictures and questions, all pairs, and no method's name")
{
    Study study = small_study();
    for (Picture& picture : study.pictures)
        picture.method = "method-" + picture.method;
    study.questions[0] = "Is </script><b>this</b> sharper?";
    const std::string text = page(study, {"data:0", "data:1", "data:2", "data:3", "data:4", "data:5"});
    CHECK(text.find("method-") == std::string::npos);
    CHECK(text.find("<!--STYLE-->") == std::string::npos);
    CHECK(text.find("<!--SCRIPT-->") == std::string::npos);
    CHECK(text.find("http://") == std::string::npos);
    CHECK(text.find("https://") == std::string::npos);
    const fresco::Value data = data_of(text);
    CHECK(data.at("study").as_string() == study.id);
    CHECK(data.at("questions").as_list().front().as_string() == study.questions[0]);
    CHECK(data.at("pictures").as_list().size() == 6);
    CHECK(data.at("pairs_count").as_int() == 6);
    // In each pair the smaller number first: the order does not tell the method.
    CHECK(data.at("strata") == fresco::parse_json("[[[0, 2], [1, 3]], [[4, 5]]]"));
    CHECK_FALSE(data.at("mixes_questions").as_bool());

    study.design = {"method-b", true, {{"two", 1, 0.5, 0, 0.25, 1}, {"one", {}, 0, 0, 1, 1}}};
    const fresco::Value changed = data_of(page(study, {"data:0", "data:1", "data:2", "data:3", "data:4", "data:5"}));
    CHECK(changed.at("mixes_questions").as_bool());
    // By picture's number: of view one 0 and 2, of two 1 and 3.
    CHECK(changed.at("hints") ==
          fresco::parse_json("[[[null, 0.0, 0.0, 1.0, 1.0]], [[1, 0.5, 0.0, 0.25, 1.0]], [[null, 0.0, 0.0, 1.0, 1.0]], "
                             "[[1, 0.5, 0.0, 0.25, 1.0]], [], []]"));
}
