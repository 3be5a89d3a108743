// SPDX-License-Identifier: Apache-2.0
// What belongs to no shadow link of a light is not in its way: surfaces show the same with it as without, whether a
// path finds the light by a sample or by its own direction.
#include "stfLib/reference/reference_integrator.h"
#include "tests/unit/render/slab_fixture.h"

#include <cmath>

namespace stf::test {
namespace {

enum class Floor { Shell, RefractingShell, Matte, Glossy };

struct LinkCase {
    Floor floor;
    bool traced;
};

class ShadowLink : public testing::TestWithParam<LinkCase> {
protected:
    // Under a square light, 10 mm above; `blocker`: a black square halfway, out of the camera's sight.
    Slab::Measured radiance(bool blocker, const std::string& shadowLink) {
        const LinkCase& c = GetParam();
        Slab slab;
        slab.lit = Slab::Lit::Dark;
        slab.viewCosine = 0.3;
        slab.tau = 4;
        slab.extinction = 2;
        slab.quality = 0.02f;
        slab.settings.samples = c.traced ? 512 : 256;
        slab.plainColor = c.floor == Floor::Matte || c.floor == Floor::Glossy ? 0.5 : 0;
        slab.ior = c.floor == Floor::RefractingShell ? 1.4 : 1;
        if (c.traced) {
            slab.reference = &ReferenceIntegrator::maker;
            slab.settings.integrator = "reference";
        }
        slab.more = [&](Scene& scene) {
            Light light;
            light.type = Light::Type::Rect;
            light.width = light.height = 6;
            light.emission = Rgb(3.0f);
            light.lightToWorld.translation = {0, 0, 10};
            light.shadowLink = shadowLink;
            scene.setLight("/light", light);
            if (c.floor == Floor::Glossy) {
                PreviewSurface surface;
                surface.roughness = 0.4f;
                surface.diffuseColor = Rgb(0.5f);
                scene.setMaterial("/gloss", surface);
                scene.setMeshMaterial("/slab", "/gloss");
            }
            if (blocker) {
                ControlMesh square = squareMesh({0, 0, 5}, {6, 0, 0}, {0, 6, 0});
                square.colors = {Rgb(0.0f)};
                scene.setMesh("/blocker", square, 0);
                scene.setInstances("/blocker", {MeshInstance()});
            }
        };
        return slab.radiance();
    }
};

TEST_P(ShadowLink, WhatIsNotInItThrowsNoShadow) {
    const Slab::Measured open = radiance(false, ""), linked = radiance(true, "of nobody");
    EXPECT_LT(std::hypot(open.error, linked.error), 0.02 * open.mean);
    EXPECT_NEAR(linked.mean, open.mean, 4 * std::hypot(open.error, linked.error));
    EXPECT_LT(radiance(true, "").mean, 0.2 * open.mean) << "else it does";
}

std::string caseName(const testing::TestParamInfo<LinkCase>& i) {
    const char* const names[] = {"Shell", "RefractingShell", "Matte", "Glossy"};
    return std::string(names[int(i.param.floor)]) + (i.param.traced ? "Traced" : "");
}

INSTANTIATE_TEST_SUITE_P(Floors, ShadowLink,
                         testing::Values(LinkCase{Floor::Shell, false}, LinkCase{Floor::RefractingShell, false},
                                         LinkCase{Floor::Matte, false}, LinkCase{Floor::Glossy, false},
                                         LinkCase{Floor::Shell, true}, LinkCase{Floor::Matte, true},
                                         LinkCase{Floor::Glossy, true}),
                         caseName);

} // namespace
} // namespace stf::test
