// SPDX-License-Identifier: Apache-2.0
#include "stfLib/optics/delta_eddington.h"

#include "stfLib/base/error.h"
#include "tests/unit/support/files.h"

#include <cmath>

using namespace stf;
using namespace stf::test;

namespace {

const float kMeanCosines[] = {-0.999f, -0.5f, -1e-8f, 0.0f, 1e-8f, 0.1f, 0.5f, 0.9f, 0.999f, 0.999999f};
const float kAlbedos[] = {0.0f, 1e-6f, 0.5f, 0.99f, 1 - 1e-7f, 1.0f};

TEST(TransportForm, Names) {
    for (TransportForm form : {TransportForm::DE1, TransportForm::Classic}) {
        EXPECT_EQ(parseTransportForm(name(form)), form);
    }
    EXPECT_STREQ(name(TransportForm::DE1), "dE1");
    EXPECT_STREQ(name(TransportForm::Classic), "classic");
    const std::string message = messageOf<Error>([] { parseTransportForm("de1"); });
    EXPECT_NE(message.find("'de1'"), std::string::npos);
    EXPECT_NE(message.find("dE1"), std::string::npos);
    EXPECT_NE(message.find("classic"), std::string::npos);
}

TEST(DeltaEddington, ClassicIsTheTrueMedium) {
    for (float g : kMeanCosines) {
        const DeltaScale s = deltaScale(TransportForm::Classic, g);
        EXPECT_EQ(s.f, 0);
        EXPECT_EQ(s.g, g);
        for (float a : kAlbedos) {
            EXPECT_EQ(scaledExtinction(Rgb(3.1f), Rgb(a), s).x, 3.1f) << a;
            EXPECT_EQ(scaledAlbedo(Rgb(a), s).x, a);
        }
    }
}

TEST(DeltaEddington, KeepsTheMeanCosine) {
    for (float g : kMeanCosines) {
        const DeltaScale s = deltaScale(TransportForm::DE1, g);
        EXPECT_NEAR(double(s.f) + double(s.keep) * double(s.g), double(g), 1e-7) << g;
        EXPECT_NEAR(double(s.f) + double(s.keep), 1, 1e-7) << g;
        EXPECT_LE(std::abs(s.g), std::abs(g));
        if (g > 0) {
            EXPECT_EQ(s.f, g * g);
            EXPECT_LE(s.g, 0.5f);
        } else {
            EXPECT_EQ(s.f, 0);
            EXPECT_EQ(s.g, g);
        }
    }
}

TEST(DeltaEddington, ContinuousAcrossZero) {
    const DeltaScale below = deltaScale(TransportForm::DE1, -1e-8f), above = deltaScale(TransportForm::DE1, 1e-8f);
    EXPECT_NEAR(below.g, above.g, 3e-8f);
    EXPECT_NEAR(below.f, above.f, 1e-15f);
    EXPECT_EQ(scaledExtinction(Rgb(2.0f), Rgb(0.9f), below), scaledExtinction(Rgb(2.0f), Rgb(0.9f), above));
    EXPECT_EQ(deltaScale(TransportForm::DE1, -0.0f).keep, 1);
}

TEST(DeltaEddington, KeepsAbsorptionAndWhatScatteringRemains) {
    for (float g : kMeanCosines) {
        const DeltaScale s = deltaScale(TransportForm::DE1, g);
        const double keep = g > 0 ? (1 - double(g)) * (1 + double(g)) : 1.0;
        for (float a : kAlbedos) {
            for (float kappa : {1e-6f, 0.37f, 1e6f}) {
                const double extinction = double(scaledExtinction(Rgb(kappa), Rgb(a), s).y);
                const double scattering = extinction * double(scaledAlbedo(Rgb(a), s).y);
                const double absorption = extinction * double(scaledCoalbedo(Rgb(a), s).y);
                const double expected = double(kappa) * double(a) * keep;
                EXPECT_NEAR(scattering, expected, 1e-6 * expected) << g << ", " << a;
                const double absorbed = double(kappa) * (1 - double(a));
                EXPECT_NEAR(absorption, absorbed, 1e-6 * absorbed) << g << ", " << a;
            }
        }
    }
}

TEST(DeltaEddington, AlbedoStaysAnAlbedo) {
    for (float g : kMeanCosines) {
        const DeltaScale s = deltaScale(TransportForm::DE1, g);
        EXPECT_EQ(scaledAlbedo(Rgb(1.0f), s).x, 1) << g;
        EXPECT_EQ(scaledCoalbedo(Rgb(1.0f), s).x, 0) << g;
        EXPECT_EQ(scaledAlbedo(Rgb(0.0f), s).x, 0) << g;
        for (float a : kAlbedos) {
            const float scaled = scaledAlbedo(Rgb(a), s).z;
            EXPECT_TRUE(scaled >= 0 && scaled <= 1) << g << ", " << a;
            EXPECT_LE(scaled, a + 1.2e-7f) << g; // what counts as unscattered leaves the rest darker
            EXPECT_NEAR(double(scaled) + double(scaledCoalbedo(Rgb(a), s).z), 1, 2e-7) << g << ", " << a;
        }
    }
}

TEST(DeltaEddington, ChannelsAreIndependent) {
    const DeltaScale s = deltaScale(TransportForm::DE1, 0.8f);
    const Rgb kappa(1, 0, 1e3f), albedo(0, 0.5f, 1);
    for (int c = 0; c < 3; ++c) {
        EXPECT_EQ(scaledExtinction(kappa, albedo, s)[c], scaledExtinction(Rgb(kappa[c]), Rgb(albedo[c]), s).x);
        EXPECT_EQ(scaledAlbedo(albedo, s)[c], scaledAlbedo(Rgb(albedo[c]), s).x);
    }
    EXPECT_EQ(scaledExtinction(kappa, albedo, s).y, 0);
}

} // namespace
