// SPDX-License-Identifier: Apache-2.0
#include "stfLib/optics/property_table.h"

#include "stfLib/base/error.h"
#include "stfLib/optics/materials_json.h"
#include "tests/unit/support/files.h"

#include <gmock/gmock.h>

using namespace stf;
using namespace stf::test;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

namespace {

void expectNear(const Vec3d& a, const Vec3d& b, double relative) {
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(a[c], b[c], relative * std::abs(b[c]) + 1e-15) << "channel " << c;
    }
}

std::string tableOf(const std::string& material, const std::string& units = "mm^-1") {
    return R"({"units": ")" + units + R"(", "mine": {"Soap": )" + material + "}}";
}

std::string complaint(const std::string& text) {
    return messageOf<Error>([&] { PropertyTable::parse(text, "mine.json"); });
}

TEST(PropertyTable, JensenIsReducedWithG0) {
    const Material m = PropertyTable::builtIn().find("Marble");
    EXPECT_EQ(m.name, "Marble");
    expectNear(m.sigmaA, {0.0021, 0.0041, 0.0071}, 1e-14);
    expectNear(m.sigmaS, {2.19, 2.62, 3.0}, 1e-14);
    EXPECT_EQ(m.g, 0);
    EXPECT_EQ(m.ior, 1.5);
    EXPECT_THAT(m.source, HasSubstr("Jensen"));
}

// sigma_s' as pbrt-v3 tabulates it, as far as the digits of sigma_s (five after the point) and g (three) reach.
TEST(PropertyTable, NarasimhanKeepsReducedScatteringOfEveryChannel) {
    const nlohmann::json data = nlohmann::json::parse(builtInMaterialsJson())["narasimhan2006"];
    int compared = 0;
    for (const auto& [name, values] : data.items()) {
        SCOPED_TRACE(name);
        const Material m = PropertyTable::builtIn().find("narasimhan2006/" + name);
        double low = 1, high = -1;
        for (int c = 0; c < 3; ++c) {
            const std::size_t i = std::size_t(c);
            const double sigmaS = values["sigma_s"][i].get<double>(), g = values["g"][i].get<double>();
            const double rounding = 5e-4 * sigmaS + 5e-6 * (1 - g) + 1e-4 * m.sigmaSPrime()[c];
            EXPECT_NEAR(m.sigmaSPrime()[c], values["sigma_s_prime_pbrt"][i].get<double>(), rounding);
            EXPECT_NEAR(m.sigmaSPrime()[c], sigmaS * (1 - g), 1e-14);
            EXPECT_EQ(m.sigmaA[c], values["sigma_a"][i].get<double>());
            if (values["sigma_s"][i].get<double>() > 0) {
                low = std::min(low, values["g"][i].get<double>());
                high = std::max(high, values["g"][i].get<double>());
            }
        }
        EXPECT_GE(m.g, low - 1e-12);
        EXPECT_LE(m.g, high + 1e-12);
        ++compared;
    }
    EXPECT_EQ(compared, 35);
}

TEST(PropertyTable, AnotherMeanCosineIsSimilar) {
    const Material a = PropertyTable::builtIn().find("Marble"), b = PropertyTable::builtIn().find("marble@g=0.8");
    EXPECT_EQ(b.g, 0.8);
    expectNear(b.sigmaSPrime(), a.sigmaSPrime(), 1e-14);
    expectNear(b.sigmaS, a.sigmaS * 5.0, 1e-14);
    EXPECT_EQ(b.sigmaA, a.sigmaA);
    for (const char* bad : {"marble@g=1", "marble@g=-1", "marble@g=", "marble@h=0.5", "marble@g=0.5x", "marble@"}) {
        EXPECT_THROW(PropertyTable::builtIn().find(bad), Error) << bad;
    }
}

TEST(PropertyTable, Names) {
    const PropertyTable& t = PropertyTable::builtIn();
    EXPECT_EQ(t.find("low-fat soy_milk").name, "Lowfat Soy Milk");
    EXPECT_EQ(t.find("jensen2001/apple").name, "Apple");
    EXPECT_TRUE(t.find("none").isVoid());
    EXPECT_TRUE(t.find("Void").isVoid());
    EXPECT_EQ(t.materials().size(), t.ownCount());
    EXPECT_GE(t.ownCount(), 47u);
    EXPECT_EQ(t.qualifiedName(0), "jensen2001/Apple");
    EXPECT_THAT(messageOf<Error>([&] { t.find("Marbel"); }), AllOf(HasSubstr("Marbel"), HasSubstr("Marble")));
    EXPECT_THAT(messageOf<Error>([&] { t.find("jensen2001/Marbel"); }), HasSubstr("jensen2001/Marble"));
    EXPECT_THAT(messageOf<Error>([&] { t.find("adamantium"); }), Not(HasSubstr("did you mean")));
    EXPECT_THROW(t.find(""), Error);
}

TEST(PropertyTable, UsersTableStandsBeforeTheBuiltIn) {
    const TemporaryFolder folder;
    std::ofstream(folder.file("mine.json")) << R"({"units": "cm^-1", "sources": {"mine": "the lab"},
        "mine": {"Marble": {"sigma_a": 2, "sigma_s_prime": [10, 20, 30], "g": 0.5, "eta": 1.2},
                 "Soap": {"sigma_a": [1, 2, 3], "sigma_s": 4}},
        "yours": {"soap": {"sigma_a": 1, "sigma_s": 1}}})";
    const PropertyTable t = PropertyTable::read(folder.file("mine.json"));
    EXPECT_EQ(t.ownCount(), 3u);
    const Material m = t.find("Marble");
    expectNear(m.sigmaA, Vec3d(0.2), 1e-14);
    expectNear(m.sigmaS, {2, 4, 6}, 1e-14);
    expectNear(m.sigmaSPrime(), {1, 2, 3}, 1e-14);
    EXPECT_EQ(m.ior, 1.2);
    EXPECT_EQ(m.source, "the lab");
    EXPECT_EQ(t.find("jensen2001/Marble").ior, 1.5);
    EXPECT_EQ(t.find("Ketchup").name, "Ketchup") << "the built-in ones are still there";
    EXPECT_THAT(messageOf<Error>([&] { t.find("soap"); }), AllOf(HasSubstr("mine/Soap"), HasSubstr("yours/soap")));
    EXPECT_EQ(t.find("mine/soap").ior, 1);
    EXPECT_THAT(messageOf<Error>([] { PropertyTable::read("/nowhere/t.json"); }), HasSubstr("/nowhere/t.json"));
}

TEST(PropertyTable, BadTablesAreToldByMaterialAndField) {
    const auto expect = [](const std::string& text, std::vector<std::string> parts) {
        const std::string told = complaint(text);
        parts.push_back("mine.json");
        for (const std::string& part : parts) {
            EXPECT_THAT(told, HasSubstr(part));
        }
    };
    expect(tableOf(R"({"sigma_a": [1, -2, 3], "sigma_s": 4})"), {"mine/Soap", "sigma_a", "-2"});
    expect(tableOf(R"({"sigma_a": [1, NaN, 3], "sigma_s": 4})"), {"mine/Soap", "sigma_a"});
    expect(tableOf(R"({"sigma_a": [1, 2, 3], "sigma_s": 1e999})"), {"mine/Soap", "sigma_s"});
    expect(tableOf(R"({"sigma_a": [1, null, 3], "sigma_s": 4})"), {"mine/Soap", "sigma_a", "null"});
    expect(tableOf(R"({"sigma_a": [1, 2], "sigma_s": 4})"), {"mine/Soap", "sigma_a", "2 numbers"});
    expect(tableOf(R"({"sigma_a": "red", "sigma_s": 4})"), {"mine/Soap", "sigma_a", "red"});
    expect(tableOf(R"({"sigma_s": 4})"), {"mine/Soap", "sigma_a", "missing"});
    expect(tableOf(R"({"sigma_a": 4})"), {"mine/Soap", "sigma_s"});
    expect(tableOf(R"({"sigma_a": 4, "sigma_s": 1, "sigma_s_prime": 1})"), {"mine/Soap", "sigma_s_prime"});
    expect(tableOf(R"({"sigma_a": 4, "sigma_s": 1, "g": 1})"), {"mine/Soap", "g is 1"});
    expect(tableOf(R"({"sigma_a": 4, "sigma_s": 1, "eta": 0})"), {"mine/Soap", "eta"});
    expect(tableOf(R"({"sigma_a": 4, "sigma_s_prime": 1, "g": [0.1, 0.2, 0.3]})"), {"mine/Soap", "g differs"});
    expect(tableOf(R"({"sigma_a": 4, "sigma_s": 1, "sigma_q": 1})"), {"mine/Soap", "sigma_q", "did you mean"});
    expect(tableOf("4"), {"mine/Soap"});
    expect(tableOf(R"({"sigma_a": 4, "sigma_s": 1})", "furlong"), {"units", "furlong", "mm^-1"});
    expect(R"({"mine": {"Soap": {"sigma_a": 4, "sigma_s": 1}}})", {"units"});
    expect(R"({"units": "1/mm", "mine": 3})", {"mine"});
    expect(R"({"units": "1/mm"})", {"no material"});
    expect(R"([1, 2])", {"object"});
    expect("", {"not a table"});
    const std::string soap = R"({"sigma_a": 4, "sigma_s": 1})";
    expect(R"({"units": "1/mm", "mine": {"Soap": )" + soap + R"(, "Soap": )" + soap + "}}", {"mine/Soap", "twice"});
    expect(R"({"units": "1/mm", "mine": {"Soap": )" + soap + R"(, "so ap": )" + soap + "}}", {"mine/Soap", "so ap"});
    expect(R"({"units": "1/mm", "mine": {"none": )" + soap + "}}", {"mine/none"});
}

TEST(PropertyTable, MaterialsAreWrittenOutInRecipes) {
    const Material m = parseMaterial(
        R"({"name": "resin", "sigma_a": [0.1, 0.2, 0.3], "sigma_s_prime": 2, "g": 0.5, "ior": 1.5})", "m");
    EXPECT_EQ(m.name, "resin");
    EXPECT_EQ(m.sigmaA, Vec3d(0.1, 0.2, 0.3));
    EXPECT_EQ(m.sigmaS, Vec3d(4.0));
    EXPECT_EQ(m.ior, 1.5);
    EXPECT_TRUE(parseMaterial("{}", "m").isVoid());
    const char* const bad[] = {
        R"({"sigma_s": -1})",   R"({"sigma_s": 1, "g": 1})", R"({"sigmas": 1})", R"({"ior": 1, "eta": 1})", "3",
        R"({"sigma_a": "red"})"};
    for (const char* text : bad) {
        try {
            parseMaterial(text, "matrix");
            ADD_FAILURE() << text;
        } catch (const Error& e) {
            EXPECT_EQ(std::string(e.what()).rfind("matrix", 0), 0u) << e.what();
        }
    }
}

} // namespace
