// SPDX-License-Identifier: Apache-2.0
#include "stfLib/transport/coarse_tile.h"

#include "stfLib/base/random.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace stf::test {
namespace {

// 8 x 4 x 3 voxels of random coefficients, some of them void.
BaseVolume mixed() {
    BaseVolume v;
    v.size = {8, 4, 3};
    v.voxelMm = {0.1, 0.2, 0.05};
    CounterRng rng(3, 1);
    for (std::size_t i = 0; i < v.voxelCount(); ++i) {
        const float k = rng.uniform() < 0.2f ? 0.0f : 5 * rng.uniform();
        v.extinction.push_back(Rgb(k, 0.5f * k, 2 * k));
        v.albedo.push_back(Rgb(rng.uniform(), rng.uniform(), rng.uniform()));
        v.g.push_back(0.8f * rng.uniform());
    }
    return v;
}

FactoredField randomField(const BaseVolume& v) {
    FactoredField f;
    f.rank = 2;
    f.components = 12;
    f.directions = 1;
    f.basis = {1, 0.5f};
    CounterRng rng(4, 1);
    for (std::size_t i = 0; i < v.voxelCount() * 24; ++i) {
        f.factors.push_back(rng.uniform());
    }
    return f;
}

StfTable tableOf(const BaseVolume& v) {
    StfTable t;
    t.size = v.size;
    t.voxelMm = v.voxelMm;
    t.directions = DirectionSet(1, 1);
    t.multiple = randomField(v);
    t.backlight = randomField(v);
    return t;
}

// Sum over the voxels of a layer of what they scatter of a field's factor k, component c.
double scattered(const TileMedium& m, const FactoredField& f, int layer, int k, int c) {
    const std::size_t n = std::size_t(m.size().x) * std::size_t(m.size().y);
    double sum = 0;
    for (std::size_t i = n * std::size_t(layer); i < n * std::size_t(layer + 1); ++i) {
        const TileMedium::Voxel& v = m.voxel(i);
        sum +=
            double(v.scattering[c % 3]) * double(v.keep) *
            double(f.factors[(i * std::size_t(f.rank) + std::size_t(k)) * std::size_t(f.components) + std::size_t(c)]);
    }
    return sum / double(n);
}

TEST(CoarseTile, EachLayerScattersAndAbsorbsWhatItsVoxelsDid) {
    BaseVolume v = mixed();
    v.g.assign(v.voxelCount(), 0.6f);
    for (TransportForm form : {TransportForm::DE1, TransportForm::Classic}) {
        const TileMedium medium(v, form);
        const CoarseTile c = coarsenTile(v, medium, tableOf(v), 2, true);
        EXPECT_EQ(c.medium->size(), Vec3i(4, 2, 3));
        EXPECT_DOUBLE_EQ(c.medium->voxelMm().x, 0.2);
        for (int z = 0; z < 3; ++z) {
            for (int k = 0; k < 3; ++k) {
                double fine = 0, coarse = 0, fineAll = 0, coarseAll = 0;
                for (int i = 0; i < 32; ++i) {
                    fine += double(medium.voxel(std::size_t(32 * z + i)).scattering[k]) / 32;
                    fineAll += double(medium.voxel(std::size_t(32 * z + i)).extinction[k]) / 32;
                }
                for (int i = 0; i < 8; ++i) {
                    coarse += double(c.medium->voxel(std::size_t(8 * z + i)).scattering[k]) / 8;
                    coarseAll += double(c.medium->voxel(std::size_t(8 * z + i)).extinction[k]) / 8;
                }
                EXPECT_NEAR(coarse, fine, 1e-5 * fine);
                EXPECT_NEAR(coarseAll, fineAll, 1e-5 * fineAll);
            }
        }
    }
}

TEST(CoarseTile, TheLightThatALayerScattersIsKept) {
    BaseVolume v = mixed();
    v.g.assign(v.voxelCount(), 0.6f); // where g varies, so does the share that the form keeps
    const TileMedium medium(v, TransportForm::DE1);
    const StfTable table = tableOf(v);
    const CoarseTile c = coarsenTile(v, medium, table, 2, true);
    for (int z = 0; z < 3; ++z) {
        for (int k = 0; k < 2; ++k) {
            for (int component = 0; component < 12; ++component) {
                const double fine = scattered(medium, table.multiple.get(), z, k, component);
                EXPECT_NEAR(scattered(*c.medium, c.table->multiple.get(), z, k, component), fine, 1e-5 * fine);
                const double core = scattered(medium, table.backlight.get(), z, k, component);
                EXPECT_NEAR(scattered(*c.medium, c.table->backlight.get(), z, k, component), core, 1e-5 * core);
            }
        }
    }
}

TEST(CoarseTile, AUniformFieldStaysWhatItIs) {
    const BaseVolume v = mixed();
    StfTable table = tableOf(v);
    FactoredField field = table.multiple.get();
    field.factors.assign(field.factors.size(), 0.75f);
    table.multiple = field;
    const CoarseTile c = coarsenTile(v, TileMedium(v, TransportForm::DE1), table, 2, false);
    EXPECT_THAT(c.table->multiple->factors, ::testing::Each(::testing::FloatNear(0.75f, 1e-6f)));
    EXPECT_TRUE(c.table->backlight->empty());
}

TEST(CoarseTile, SaysWhatCannotBeCoarsened) {
    BaseVolume v = mixed();
    const TileMedium medium(v, TransportForm::DE1);
    EXPECT_TRUE(canCoarsen(v, medium, 2));
    EXPECT_FALSE(canCoarsen(v, medium, 4)); // one column along y
    EXPECT_FALSE(canCoarsen(v, medium, 1));
    BaseVolume relief = v;
    relief.surface.assign(v.voxelCount(), -1.0f);
    relief.surface[0] = 0.02f;
    EXPECT_FALSE(canCoarsen(relief, TileMedium(relief, TransportForm::DE1), 2));
    StfTable alien = tableOf(v);
    FactoredField shorter = alien.multiple.get();
    shorter.factors.resize(shorter.factors.size() / 2);
    alien.multiple = shorter;
    EXPECT_THROW(coarsenTile(v, medium, alien, 2, false), Error);
    EXPECT_THROW(coarsenTile(v, medium, tableOf(v), 4, false), Error);
}

} // namespace
} // namespace stf::test
