#include "balance.h"
#include "fakes.h"

#include "catch.h"

using namespace fresco;
using namespace fresco::optimize;

namespace
{

/// Compares features with the camera's, or only with the style.
class FeatureLoss final : public Loss
{
  public:
    explicit FeatureLoss(bool sees_camera) : sees_camera_(sees_camera) {}
    LossNeeds needs() const override { return {{{.network = nullptr, .names = {"a"}, .camera = sees_camera_}}, false}; }
    void prepare(const PrepareContext&) override {}
    std::vector<LossTerm> evaluate(Part&) override { return {}; }

  private:
    bool sees_camera_;
};

}  // namespace

TEST_CASE("style over content is reported, and warned about where a run begins empty")
{
    const std::map<std::string, std::shared_ptr<Loss>> losses{{"content", std::make_shared<FeatureLoss>(true)},
                                                              {"picture", std::make_shared<fakes::CameraLoss>()},
                                                              {"style", std::make_shared<FeatureLoss>(false)},
                                                              {"more_style", std::make_shared<FeatureLoss>(false)}};
    const auto ratio = [&](const std::map<std::string, double>& summands) { return style_over_content(losses, summands); };
    CHECK(ratio({{"content", 2}, {"picture", 100}, {"style", 1}, {"more_style", 2}}) == 1.5);
    CHECK_FALSE(ratio({{"content", 0}, {"style", 1}}));
    CHECK_FALSE(ratio({{"content", 1}, {"picture", 1}}));

    const auto warnings = [&](double style, bool begins_empty)
    {
        testing::TestRun run;
        report_balance(losses, {{"content", 10}, {"style", style}}, begins_empty, run);
        CHECK(run.reported.at("initial_style_over_content").as_double() == Approx(style / 10));
        return run.messages.size();
    };
    CHECK(warnings(15, true) == 0);
    CHECK(warnings(2.9, true) == 1);
    CHECK(warnings(81, true) == 1);
    CHECK(warnings(1000, false) == 0);
}
