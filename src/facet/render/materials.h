// SPDX-License-Identifier: BSD-2-Clause
// What surfaces are made of.
#pragma once

#include <filesystem>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "facet/render/texture.h"

namespace facet {

struct Material {
  std::string name;
  Texture texture;
  double tile_m = 1;  ///< side of the area that the texture covers; 0: a picture that covers its
                      ///< surface exactly once
  double gloss = 0;   ///< weight of the mirror-like part of the light, 0 matt to 1
  double glow = 0;    ///< radiance of its own: lamps, windows
};

/// Everything a scene can be made of. Names: see Names().
class MaterialLibrary {
 public:
  /// Nothing is painted yet. Pictures (photo..., print...) come from the images in `image_folder`
  /// if it is not empty. Throws InputError for a folder without images and for unreadable ones.
  MaterialLibrary(std::uint64_t seed, const std::filesystem::path& image_folder);

  /// Paints the textures of these materials, if they are not there yet. The result does not depend
  /// on the number of threads, nor on which materials are painted.
  void Paint(const std::set<int>& used, int num_threads);

  const std::vector<Material>& materials() const { return materials_; }

  /// Index of a material; -1 if there is none of this name.
  int Find(const std::string& name) const;
  /// CHECKs that the name is known.
  int Get(const std::string& name) const;
  /// Adds an image file as a picture. Throws InputError.
  int AddPicture(const std::filesystem::path& file);
  /// A random picture (photograph or print).
  int RandomPicture(Rng& rng) const;
  /// "wood, plaster, ...", for messages.
  std::string Names() const;

 private:
  using Painter = std::function<GreyCanvas(Rng&)>;

  void Add(Rng& rng, const std::string& name, double tile_m, double gloss, Painter painter);
  void AddCommon(Rng& rng);
  void AddPictures(Rng& rng, const std::filesystem::path& image_folder);
  /// Machines, fronts of buildings and the ground before them, too.
  void AddForOfficeAndYard(Rng& rng);

  std::vector<Material> materials_;
  std::vector<Painter> painters_;     // by material; empty for image files
  std::vector<std::uint64_t> seeds_;  // of the painters
  std::vector<int> pictures_;
};

}  // namespace facet
