// SPDX-License-Identifier: Apache-2.0
#include "stfLib/base/parallel.h"
#include "tests/unit/support/chi_square.h"
#include "tests/unit/support/files.h"
#include "tools/stf/slab_stf.h"
#include "tools/stf/slab_walk.h"

using namespace stf;
using namespace stf::test;

namespace {

SlabOptions parsed(std::vector<std::string> words) {
    CLI::App app;
    SlabArguments arguments;
    arguments.addTo(app);
    std::reverse(words.begin(), words.end()); // as CLI11 takes them
    app.parse(words);
    return arguments.parse();
}

SlabResult walked(const std::vector<std::string>& words) {
    Progress progress;
    return slabByWalks(parsed(words), progress);
}
SlabResult tabulated(const std::vector<std::string>& words) {
    Progress progress;
    return slabByTable(parsed(words), progress);
}

std::string text(double x) {
    std::ostringstream s;
    s.precision(17);
    s << x;
    return s.str();
}

void expectWithin(double value, double error, double exact, double sigmas, double systematic = 0) {
    EXPECT_LE(std::abs(value - exact), sigmas * error + systematic + 1e-7) << value << " +- " << error;
}

TEST(SlabOptions, Defaults) {
    const SlabOptions o = parsed({});
    ASSERT_EQ(o.layers.size(), 1u);
    EXPECT_EQ(o.layers[0].tau, 1);
    EXPECT_EQ(o.ior, 1);
    EXPECT_EQ(o.mu, 1);
    EXPECT_FALSE(o.hasCore);
    EXPECT_EQ(o.method, SlabOptions::Method::Walk);
    EXPECT_EQ(o.form, TransportForm::DE1);
}

TEST(SlabOptions, Lists) {
    const SlabOptions o = parsed({"--tau", "1,2,0.5", "--g", "0.1,-0.2,0", "--albedo", "1", "--profile", "0,3.5",
                                  "--photons", "1e6", "--incidence", "0.25", "--core-albedo", "0.5"});
    ASSERT_EQ(o.layers.size(), 3u);
    EXPECT_EQ(o.layers[2].tau, 0.5);
    EXPECT_EQ(o.layers[1].g, -0.2);
    EXPECT_EQ(o.layers[1].albedo, 1);
    EXPECT_EQ(o.tau(), 3.5);
    EXPECT_EQ(o.photons, 1000000u);
    EXPECT_EQ(o.mu, 0.25);
    EXPECT_TRUE(o.hasCore);
    EXPECT_EQ(o.profile.size(), 2u);
}

TEST(SlabOptions, RefusesWhatIsNoSlab) {
    const std::vector<std::pair<std::vector<std::string>, std::string>> bad{
        {{"--tau", "-1"}, "--tau -1"},
        {{"--tau", "nan"}, "--tau nan"},
        {{"--tau", "inf"}, "--tau inf"},
        {{"--albedo", "1.1"}, "--albedo 1.1"},
        {{"--albedo", "-0.1"}, "--albedo"},
        {{"--g", "1"}, "--g 1"},
        {{"--g", "-1.5"}, "--g"},
        {{"--g", "0.999999999"}, "--g"},
        {{"--ior", "0.9"}, "--ior 0.9"},
        {{"--ior", "3"}, "--ior 3"},
        {{"--ior", "nan"}, "--ior"},
        {{"--incidence", "0"}, "--incidence 0"},
        {{"--incidence", "1.5"}, "--incidence"},
        {{"--incidence", "sideways"}, "sideways"},
        {{"--incidence", ""}, "--incidence"},
        {{"--photons", "0"}, "--photons 0"},
        {{"--photons", "1.5"}, "--photons"},
        {{"--photons", "-3"}, "--photons"},
        {{"--tau", "1,2", "--g", "0,0,0"}, "3 layers"},
        {{"--core-g", "0.5"}, "--core-albedo"},
        {{"--core-albedo", "2"}, "--core-albedo 2"},
        {{"--core-albedo", "0.5", "--core-g", "1"}, "--core-g"},
        {{"--profile", "2"}, "--profile 2"},
        {{"--profile", "nan"}, "--profile"},
        {{"--method", "magic"}, "magic"},
        {{"--form", "dE7"}, "--form"},
        {{"--quality", "0"}, "--quality"},
        {{"--threads", "-2"}, "--threads"},
    };
    for (const auto& [words, told] : bad) {
        const std::string message = messageOf<CLI::ParseError>([&, w = words] { parsed(w); });
        EXPECT_NE(message.find(told), std::string::npos) << "'" << message << "' does not name " << told;
        EXPECT_EQ(message.find('\n'), std::string::npos);
    }
}

TEST(SlabJson, HasTheContractsFields) {
    const SlabOptions o = parsed({"--tau", "1", "--profile", "0.5", "--photons", "100"});
    SlabResult r;
    r.profile.resize(1);
    const nlohmann::json j = nlohmann::json::parse(slabJson(o, r));
    for (const char* key : {"total", "specular", "stderr"}) {
        EXPECT_TRUE(j["R"][key].is_number());
    }
    for (const char* key : {"total", "unscattered", "stderr"}) {
        EXPECT_TRUE(j["T"][key].is_number());
    }
    EXPECT_TRUE(j["A"]["total"].is_number() && j["A"]["stderr"].is_number());
    EXPECT_TRUE(j["photons"].is_number() && j["seconds"].is_number());
    for (const char* key : {"depth", "I_s", "I_m", "I_b", "stderr"}) {
        EXPECT_TRUE(j["profile"][0][key].is_number());
    }
}

TEST(SlabWalk, ProfilesAreThoseOfTheReference) {
    const nlohmann::json data = reference("slab_cases.json");
    int compared = 0;
    for (const auto& c : data["internal_fluence"]) {
        std::string depths;
        for (const auto& row : c["rows"]) {
            depths += (depths.empty() ? "" : ",") + text(row["depth"]);
        }
        const bool thin = c["tau"] == 1;
        const SlabResult r = walked({"--tau", text(c["tau"]), "--albedo", text(c["albedo"]), "--g", text(c["g"]),
                                     "--profile", depths, "--photons", thin ? "200000" : "50000"});
        ASSERT_EQ(r.profile.size(), c["rows"].size());
        double squares = 0;
        for (std::size_t i = 0; i < r.profile.size(); ++i) {
            const SlabProfileRow& p = r.profile[i];
            const auto& e = c["rows"][i];
            SCOPED_TRACE("depth " + text(p.depth));
            // Near a face a window of finite width sees a bent curve: 0.1 %.
            const double m = e["I_m"], b = e["I_b"];
            expectWithin(p.single, p.singleError, e["I_s"], 4, 1e-4);
            expectWithin(p.multiple, p.multipleError, m, 4, 1e-3 * m);
            expectWithin(p.backlight, p.backlightError, b, 4, 1e-3 * b);
            const double noise = i == 0 || i + 1 == r.profile.size() ? 0.15 : 0.03; // light along a face weighs much
            EXPECT_LT(p.multipleError, noise * m);
            EXPECT_LT(p.backlightError, noise * b);
            EXPECT_LE(p.sumError, p.singleError + p.multipleError + 1e-12);
            squares += std::pow((p.multiple - m) / p.multipleError, 2);
        }
        // Depths of one run go up and down together: this is no chi-square, but errors far too small would show.
        EXPECT_LT(squares / double(r.profile.size()), 5);
        EXPECT_GT(squares / double(r.profile.size()), 0.02);
        ++compared;
    }
    EXPECT_EQ(compared, 3);
}

TEST(SlabWalk, TotalsOfLayersAndCores) {
    const SlabResult glass = walked({"--tau", "10", "--albedo", "0.999", "--g", "0.7", "--ior", "1.5", "--incidence",
                                     "diffuse", "--photons", "20000"});
    expectWithin(glass.r, glass.rError, 0.5846952, 4);
    expectWithin(glass.t, glass.tError, 0.3722846, 4);
    expectWithin(glass.specular, 0.002, 0.0917780, 4);
    expectWithin(glass.r + glass.t + glass.a, std::hypot(glass.rError, glass.tError, glass.aError), 1, 3);
    const SlabResult layers =
        walked({"--tau", "10.1,1.1,2.4", "--albedo", "0.9900990099009901,0.9090909090909091,0.8333333333333334", "--g",
                "0.9,0,0.7", "--ior", "1.37", "--photons", "20000"});
    expectWithin(layers.r, layers.rError, 0.262229, 4);
    expectWithin(layers.t, layers.tError, 0.096048, 4);
    const SlabResult core = walked({"--tau", "2", "--albedo", "0.9", "--core-albedo", "0.99", "--photons", "20000"});
    expectWithin(core.r, core.rError, 0.474229, 4);
    EXPECT_EQ(core.t, 0);
    EXPECT_GE(core.coreDepth, 2000);
    const SlabResult analog = walked({"--tau", "2", "--albedo", "0.9", "--photons", "20000", "--analog"});
    EXPECT_NEAR(analog.r + analog.t + analog.a, 1, 1e-12);
}

TEST(SlabWalk, Extremes) {
    const SlabResult nothing = walked({"--tau", "0", "--profile", "0", "--photons", "1000"});
    EXPECT_EQ(nothing.t, 1);
    EXPECT_EQ(nothing.unscattered, 1);
    EXPECT_EQ(nothing.profile[0].single, 1);
    const SlabResult pane = walked({"--tau", "0", "--ior", "1.5", "--photons", "2000"});
    expectWithin(pane.r, pane.rError, 2 * 0.04 / 1.04, 4);
    const SlabResult wall = walked({"--tau", "1e6", "--albedo", "0.9", "--photons", "5000"});
    expectWithin(wall.r, wall.rError, 0.41494748, 4); // H function
    EXPECT_EQ(wall.t, 0);
    const SlabResult one = walked({"--photons", "1", "--profile", "0.5"});
    EXPECT_TRUE(std::isfinite(one.rError) && std::isfinite(one.profile[0].multipleError));
    const SlabResult grazing = walked({"--incidence", "1e-6", "--ior", "1.3", "--photons", "1000"});
    EXPECT_GT(grazing.specular, 0.999);
}

TEST(SlabWalk, ThreadsDoNotMatter) {
    SlabResult results[2];
    for (int threads : {1, 2}) {
        setThreadCount(threads);
        results[threads - 1] = walked({"--tau", "2", "--g", "0.5", "--profile", "1", "--photons", "5001"});
    }
    setThreadCount(0);
    EXPECT_EQ(results[0].r, results[1].r);
    EXPECT_EQ(results[0].profile[0].multiple, results[1].profile[0].multiple);
    EXPECT_EQ(results[0].rError, results[1].rError);
}

TEST(SlabWalk, CancelThrows) {
    Progress progress;
    progress.cancel();
    EXPECT_THROW(slabByWalks(parsed({}), progress), Cancelled);
    EXPECT_THROW(slabByTable(parsed({}), progress), Cancelled);
}

// The renderer's own table and march, where dE1 is exact but for its grid: isotropic scattering.
TEST(SlabTable, IsotropicSlabsAreExact) {
    const auto expectTotals = [](const std::vector<std::string>& words, double r, double t, double tolerance) {
        std::vector<std::string> all = words;
        all.insert(all.end(), {"--photons", "20000", "--quality", "0.02"});
        const SlabResult s = tabulated(all);
        expectWithin(s.r, s.rError, r, 4, tolerance * r);
        expectWithin(s.t, s.tError, t, 4, tolerance * t);
        EXPECT_LE(s.rError, 0.02 * r);
        // The absorbed light is that of the table's fluence.
        expectWithin(s.r + s.t + s.a, std::hypot(s.rError, s.tError, s.aError), 1, 4, 0.01);
    };
    expectTotals({"--tau", "1", "--albedo", "0.9", "--ior", "1.33"}, 0.225472, 0.541360, 0.01);
    expectTotals({"--tau", "1", "--albedo", "1", "--ior", "1.5", "--incidence", "diffuse"}, 0.420330, 0.579670, 0.01);
    expectTotals({"--tau", "5", "--albedo", "0", "--ior", "1"}, 0, std::exp(-5), 1e-3);
}

// Diffuse light seen at a cosine is what is reflected of parallel light from there: Helmholtz's reciprocity, which
// isotropic tables keep.
TEST(SlabTable, ViewsAreReciprocal) {
    const std::vector<std::string> slab = {"--tau", "2", "--albedo", "0.9", "--ior", "1.3"};
    std::vector<std::string> words = slab;
    words.insert(words.end(),
                 {"--photons", "20000", "--quality", "0.01", "--method", "stf", "--incidence", "diffuse", "--view"});
    const double cosines[] = {0.9, 0.5, 0.2};
    words.push_back(text(cosines[0]) + "," + text(cosines[1]) + "," + text(cosines[2]));
    const SlabResult seen = tabulated(words);
    ASSERT_EQ(seen.view.size(), 3u);
    for (int i = 0; i < 3; ++i) {
        std::vector<std::string> other = slab;
        other.insert(other.end(), {"--photons", "200000", "--incidence", text(cosines[i])});
        const SlabResult lit = walked(other);
        EXPECT_LE(seen.view[std::size_t(i)].error, 0.01);
        expectWithin(seen.view[std::size_t(i)].factor, std::hypot(seen.view[std::size_t(i)].error, lit.rError), lit.r,
                     4, 0.01 * lit.r);
    }
    EXPECT_THROW(parsed({"--view", "0.5"}), CLI::ValidationError); // walks tell it by --incidence
    EXPECT_THROW(parsed({"--method", "stf", "--view", "1.5"}), CLI::ValidationError);
}

// Light that grazes a refracting top: Fresnel's fall is not left to the interpolation between directions.
TEST(SlabTable, GrazingLightEntersByFresnel) {
    for (const double mu : {0.05, 0.2}) {
        const std::vector<std::string> slab = {"--tau", "1",     "--albedo", "1",           "--core-albedo",
                                               "0",     "--ior", "1.5",      "--incidence", text(mu)};
        std::vector<std::string> words = slab;
        words.insert(words.end(), {"--photons", "20000", "--quality", "0.005"});
        const SlabResult table = tabulated(words);
        words = slab;
        words.insert(words.end(), {"--photons", "400000"});
        const SlabResult walks = walked(words);
        expectWithin(table.a, std::hypot(table.aError, walks.aError), walks.a, 4, 0.01 * walks.a); // into the core
        expectWithin(table.r, std::hypot(table.rError, walks.rError), walks.r, 4, 0.003);
    }
}

TEST(SlabTable, ShellOverACore) {
    const SlabResult s = tabulated(
        {"--tau", "2", "--albedo", "0.9", "--core-albedo", "0.99", "--photons", "20000", "--quality", "0.02"});
    expectWithin(s.r, s.rError, 0.474229, 4, 0.01 * 0.474229);
    EXPECT_EQ(s.t, 0);
    expectWithin(s.r + s.a, std::hypot(s.rError, s.aError), 1, 4, 0.01);
}

TEST(SlabTable, ProfileOfTheTable) {
    const nlohmann::json data = reference("slab_cases.json");
    const auto& c = data["internal_fluence"][1]; // tau 5, albedo 0.99
    const SlabResult s = tabulated(
        {"--tau", "5", "--albedo", "0.99", "--profile", "0.25,1,2.5,4.5", "--photons", "1000", "--quality", "0.02"});
    for (const SlabProfileRow& p : s.profile) {
        for (const auto& row : c["rows"]) {
            if (row["depth"] == p.depth) {
                const double m = row["I_m"], b = row["I_b"];
                expectWithin(p.single, 0, row["I_s"], 0, 1e-5);
                expectWithin(p.multiple, p.multipleError, m, 4, 0.01 * m);
                expectWithin(p.backlight, p.backlightError, b, 4, 0.01 * b);
            }
        }
    }
}

} // namespace
