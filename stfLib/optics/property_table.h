// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/optics/material.h"

#include <string>
#include <vector>

namespace stf {

/// Materials by name: the published tables that are part of the program (materials.json), and tables of users in the
/// same format (docs/materials.md).
///
/// A medium has one mean cosine g. Where a table gives reduced scattering, g is what the table states (0 unless it says
/// more) and sigma_s = sigma_s' / (1 - g). Where it gives sigma_s and g per channel, g is their mean weighted with
/// sigma_s, and sigma_s is set so that every channel keeps its own sigma_s' = sigma_s (1 - g) exactly (similarity
/// relation: van de Hulst 1980, "Multiple Light Scattering", chapter 14). sigma_a is never changed.
///
/// Immutable, thread-safe.
class PropertyTable {
public:
    /// The tables of Jensen et al. 2001 and Narasimhan et al. 2006.
    static const PropertyTable& builtIn();
    /// A user's table, with the built-in materials behind it: a name that is in both means the user's. Throws Error
    /// that names the file, the material and the field: unreadable, no or unknown units, fields that are missing,
    /// unknown, negative, not finite or not numbers, the same name twice.
    static PropertyTable read(const std::string& path);
    /// The same from the text of a table; `origin` names it in messages.
    static PropertyTable parse(const std::string& text, const std::string& origin);

    /// A material by name: "Marble" or, with its table, "jensen2001/Marble"; case, spaces, hyphens and underscores do
    /// not count. "Marble@g=0.8" has that g at the same sigma_s' and sigma_a. "none" and "void" are a void. Throws
    /// Error for a name that is unknown (tells near ones) or in several tables (tells which).
    Material find(const std::string& name) const;

    /// All materials, those of the user's table first.
    const std::vector<Material>& materials() const { return materials_; }
    /// "jensen2001/Marble": the name of materials()[i] with its table.
    std::string qualifiedName(std::size_t i) const { return tables_[i] + "/" + materials_[i].name; }
    /// How many of materials() are of the user's table, or of the built-in ones where there is no other.
    std::size_t ownCount() const { return own_; }

private:
    void add(const std::string& table, const Material& material);

    std::vector<Material> materials_;
    std::vector<std::string> tables_; ///< of each material
    std::size_t own_ = 0;
};

/// A material written out in a recipe: a JSON object with the fields of a table's material (coefficients in 1/mm),
/// where `ior` may stand for `eta`, and a `name`; coefficients that are left out are 0. Throws Error that begins with
/// `where`, as PropertyTable::read does.
Material parseMaterial(const std::string& json, const std::string& where);

/// The same medium to diffusing light with another mean cosine: sigma_s' and sigma_a stay. -1 < g < 1, else Error.
Material withMeanCosine(const Material& material, double g);

} // namespace stf
