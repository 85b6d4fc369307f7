// SPDX-License-Identifier: BSD-2-Clause
#include "facet/render/materials.h"

#include <algorithm>

#include <opencv2/imgproc.hpp>

#include "facet/base/check.h"
#include "facet/io/errors.h"
#include "facet/io/image_reader.h"
#include "facet/render/parallel_for.h"

namespace facet {
namespace {

constexpr int kLarge = 2048, kMedium = 1024, kSmall = 512;  // sides of textures [px]

/// Painted walls: hardly any texture, a few stains and scratches.
GreyCanvas Plaster(int size_px, double contrast, Rng& rng) {
  GreyCanvas canvas(0.72 + contrast * FractalNoise({size_px, 4, 1, 0.9}, rng));
  Speckle(canvas, size_px / 8, 5, 0.25, rng);
  Scratch(canvas, size_px / 12, 0.12, rng);
  return canvas;
}

GreyCanvas Concrete(int size_px, Rng& rng) {
  GreyCanvas canvas(0.5 + 0.07 * FractalNoise({size_px, 2, 1, 1}, rng));
  Speckle(canvas, size_px * 3, 7, 0.25, rng);
  Scratch(canvas, size_px / 6, 0.15, rng);
  for (int i = 1; i < 3; ++i)  // joints of the formwork
    cv::line(canvas, {0, i * size_px / 3}, {size_px, i * size_px / 3}, cv::Scalar(0.3), 3);
  return canvas;
}

/// Speckled floor covering, worn.
GreyCanvas Linoleum(int size_px, Rng& rng) {
  GreyCanvas canvas(0.5 + 0.05 * FractalNoise({size_px, 2, 1, 1}, rng));
  Speckle(canvas, size_px * 10, 5, 0.16, rng);
  Scratch(canvas, size_px / 3, 0.1, rng);
  return canvas;
}

GreyCanvas Carpet(int size_px, Rng& rng) {
  GreyCanvas canvas(0.35 + 0.08 * FractalNoise({size_px, 4, 1, 1.15}, rng));
  for (int i = 0; i < 8; ++i) {  // woven border lines
    const int at = rng.Index(size_px);
    cv::line(canvas, {at, 0}, {at, size_px}, cv::Scalar(rng.Uniform(0.15, 0.7)), 6);
  }
  return canvas;
}

/// Planks with grain, knots and dark gaps.
GreyCanvas Planks(int size_px, int num_planks, Rng& rng) {
  const GreyCanvas grain(FractalNoise({size_px, 16, 16, 0.95}, rng));
  GreyCanvas canvas(0.5 + 0.07 * grain + 0.03 * FractalNoise({size_px, 2, 1, 1}, rng));
  const int step = size_px / num_planks;
  for (int i = 0; i < num_planks; ++i) {
    cv::Mat1f plank = canvas.rowRange(i * step, (i + 1) * step);
    plank += rng.Uniform(-0.12, 0.12);
    for (int knot = rng.Index(5); knot > 0; --knot) {
      const cv::Point at(rng.Index(size_px), rng.Index(step));
      const int radius = 2 + rng.Index(step / 8 + 2);
      for (int r = radius; r > 0; r -= 2)
        cv::ellipse(plank, at, {2 * r, r}, 0, 0, 360, cv::Scalar(0.2 + 0.02 * (radius - r)), 2);
    }
    cv::line(canvas, {0, i * step}, {size_px, i * step}, cv::Scalar(0.12), 3);
    const int end = rng.Index(size_px);
    cv::line(canvas, {end, i * step}, {end, (i + 1) * step}, cv::Scalar(0.12), 2);
    for (const int dx : {-12, 12}) {  // nails
      cv::circle(canvas, {end + dx, i * step + step / 4}, 2, cv::Scalar(0.1), cv::FILLED);
      cv::circle(canvas, {end + dx, i * step + 3 * step / 4}, 2, cv::Scalar(0.1), cv::FILLED);
    }
  }
  return canvas;
}

GreyCanvas Bricks(int size_px, Rng& rng) {
  GreyCanvas canvas(0.58 + 0.03 * FractalNoise({size_px, 4, 1, 1}, rng));
  constexpr int kRows = 16, kColumns = 5;
  const int height = size_px / kRows, width = size_px / kColumns;
  for (int row = 0; row < kRows; ++row) {
    for (int column = -1; column < kColumns; ++column) {
      const int x = column * width + (row % 2) * width / 2;
      const cv::Rect brick =
          cv::Rect(x + 3 + rng.Index(3), row * height + 3, width - 7, height - 6) &
          cv::Rect(0, 0, size_px, size_px);
      if (brick.area() == 0) continue;
      const GreyCanvas body(0.7 * GreyCanvas(canvas(brick)) + rng.Uniform(-0.14, 0.05));
      body.copyTo(canvas(brick));
    }
  }
  Speckle(canvas, size_px * 2, 4, 0.12, rng);
  return canvas;
}

GreyCanvas Fabric(int size_px, Rng& rng) {
  GreyCanvas canvas(0.45 + 0.12 * FractalNoise({size_px, 2, 1, 0.75}, rng));
  canvas += 0.05 * FractalNoise({size_px, size_px / 8, 8, 1}, rng);
  for (int i = 0; i < size_px; i += size_px / 32)
    cv::line(canvas, {0, i}, {size_px, i}, cv::Scalar(rng.Uniform(0.3, 0.6)), 2);
  return canvas;
}

GreyCanvas Cardboard(int size_px, Rng& rng) {
  GreyCanvas canvas(0.5 + 0.03 * FractalNoise({size_px, 2, 1, 1}, rng));
  canvas += 0.012 * FractalNoise({size_px, size_px / 8, 16, 1}, rng);
  cv::rectangle(canvas,
                {0, size_px * 7 / 16, size_px, size_px / 10},
                cv::Scalar(0.68),
                cv::FILLED);  // tape
  const int side = size_px / 4;
  const GreyCanvas label(PrintedSheet(side, rng));
  label.copyTo(canvas(cv::Rect(size_px / 12, size_px / 10, side, side)));
  const GreyCanvas stamp(PrintedSheet(side, rng) - 0.4);
  stamp.copyTo(canvas(cv::Rect(size_px * 5 / 8, size_px * 5 / 8, side, side)));
  Scratch(canvas, size_px / 10, 0.15, rng);
  return canvas;
}

GreyCanvas Metal(int size_px, Rng& rng) {
  GreyCanvas canvas(0.45 + 0.05 * FractalNoise({size_px, 16, 32, 1}, rng));
  Scratch(canvas, size_px / 4, 0.2, rng);
  for (int i = 0; i < 6; ++i) {
    const int y = rng.Index(size_px);
    cv::line(canvas, {0, y}, {size_px, y}, cv::Scalar(0.2), 3);
  }
  return canvas;
}

/// Rock, bark, soil: strong contrast at all scales.
GreyCanvas Stone(int size_px, double contrast, Rng& rng) {
  GreyCanvas canvas(0.42 + contrast * FractalNoise({size_px, 4, 1, 0.95}, rng));
  const GreyCanvas cracks(cv::abs(FractalNoise({size_px, 4, 1, 0.7}, rng)));
  canvas.setTo(0.12, cracks < 0.02);
  Speckle(canvas, size_px * 3, 5, 0.25, rng);
  return canvas;
}

GreyCanvas Leaf(int size_px, Rng& rng) {
  GreyCanvas canvas(0.4 + 0.08 * FractalNoise({size_px, 4, 1, 0.9}, rng));
  for (int i = 0; i < 10; ++i) {
    const int y = i * size_px / 10;
    cv::line(canvas, {size_px / 2, y}, {size_px, y + size_px / 5}, cv::Scalar(0.62), 2);
    cv::line(canvas, {size_px / 2, y}, {0, y + size_px / 5}, cv::Scalar(0.62), 2);
  }
  cv::line(canvas, {size_px / 2, 0}, {size_px / 2, size_px}, cv::Scalar(0.7), 4);
  return canvas;
}

GreyCanvas WarningTape(int size_px) {
  GreyCanvas canvas(size_px, size_px, 0.85F);
  for (int i = -4; i < 4; ++i) {
    const int x = i * size_px / 4;
    const cv::Point corners[] = {
        {x, 0}, {x + size_px / 8, 0}, {x + size_px / 8 + size_px, size_px}, {x + size_px, size_px}};
    cv::fillConvexPoly(canvas, corners, 4, cv::Scalar(0.06), cv::LINE_AA);
  }
  return canvas;
}

/// A board that was written on and wiped.
GreyCanvas Whiteboard(int size_px, Rng& rng) {
  GreyCanvas canvas(0.86 + 0.012 * FractalNoise({size_px, 2, 1, 1}, rng));
  cv::rectangle(canvas, {0, 0, size_px, size_px}, cv::Scalar(0.4), 12);
  for (int i = 0; i < 26; ++i) {  // words and sketches: strokes that go on from each other
    cv::Point at(rng.Index(size_px), rng.Index(size_px));
    const double ink = rng.Uniform(0.1, 0.5);
    for (int stroke = 6 + rng.Index(24); stroke > 0; --stroke) {
      const cv::Point next = at + cv::Point(rng.Index(30) - 8, rng.Index(44) - 22);
      cv::line(canvas, at, next, cv::Scalar(ink), 3, cv::LINE_AA);
      at = next;
    }
  }
  return canvas;
}

/// A screen with a few windows of text on it.
GreyCanvas Screen(int size_px, Rng& rng) {
  GreyCanvas canvas(0.22 + 0.03 * FractalNoise({size_px, 2, 1, 1.2}, rng));
  for (int i = 0; i < 3; ++i) {
    const int side = size_px / 2;
    const GreyCanvas sheet(0.75 * PrintedSheet(side, rng));
    sheet.copyTo(
        canvas(cv::Rect(rng.Index(size_px - side), rng.Index(size_px - side), side, side)));
  }
  cv::rectangle(canvas, {0, 0, size_px, size_px}, cv::Scalar(0.05), size_px / 24);
  return canvas;
}

/// Sheet metal of a machine: painted, with seams, vents, screws, signs and stains.
GreyCanvas MachineCover(int size_px, double grey, Rng& rng) {
  GreyCanvas canvas(grey + 0.03 * FractalNoise({size_px, 2, 1, 1}, rng));
  Speckle(canvas, size_px / 3, 6, 0.2, rng);
  Scratch(canvas, size_px / 5, 0.15, rng);
  const int middle = size_px / 3 + rng.Index(size_px / 3);
  cv::line(canvas, {middle, 0}, {middle, size_px}, cv::Scalar(0.12), 5);
  cv::rectangle(canvas, {0, 0, size_px, size_px}, cv::Scalar(0.15), 8);
  const cv::Point vent(size_px / 16 + rng.Index(size_px / 8), size_px * 2 / 3);
  for (int i = 0; i < 9; ++i) {
    const cv::Rect slit(vent.x, vent.y + i * size_px / 40, size_px / 5, size_px / 90);
    cv::rectangle(canvas, slit, cv::Scalar(0.06), cv::FILLED);
  }
  for (int i = 0; i < 14; ++i) {
    const cv::Point at(i % 2 ? middle + 20 : size_px - 24, (i / 2 + 1) * size_px / 8);
    cv::circle(canvas, at, size_px / 120, cv::Scalar(0.1), cv::FILLED);
  }
  const int side = size_px / 8;  // sheets have sides of a power of two
  const GreyCanvas sign(PrintedSheet(side, rng));
  sign.copyTo(canvas(cv::Rect(size_px * 3 / 4, size_px / 8, side, side)));
  return canvas;
}

/// Ribs of a metal wall or roof.
GreyCanvas Sheeting(int size_px, Rng& rng) {
  GreyCanvas canvas(0.55 + 0.04 * FractalNoise({size_px, 2, 1, 1}, rng));
  for (int i = 0; i < 16; ++i) {
    const int x = i * size_px / 16;
    cv::line(canvas, {x, 0}, {x, size_px}, cv::Scalar(0.38), size_px / 120);
    cv::line(canvas, {x + size_px / 60, 0}, {x + size_px / 60, size_px}, cv::Scalar(0.68), 3);
  }
  Speckle(canvas, size_px, 5, 0.15, rng);
  return canvas;
}

/// Outer render: weathered, with streaks below what juts out.
GreyCanvas Render(int size_px, double contrast, Rng& rng) {
  GreyCanvas canvas(0.62 + contrast * FractalNoise({size_px, 2, 1, 0.95}, rng));
  canvas += 0.6 * contrast * FractalNoise({size_px, 16, 8, 1}, rng).t();
  Speckle(canvas, size_px, 4, 0.12, rng);
  return canvas;
}

/// A window pane: dark, with curtains and what it mirrors.
GreyCanvas Glass(int size_px, Rng& rng) {
  GreyCanvas canvas(0.12 + 0.06 * FractalNoise({size_px, 2, 1, 1.3}, rng));
  const int curtain = size_px / 8 + rng.Index(size_px / 4);
  for (int x = 0; x < curtain; x += size_px / 48) {
    cv::line(canvas, {x, 0}, {x, size_px}, cv::Scalar(rng.Uniform(0.3, 0.6)), size_px / 50);
    const int right = size_px - x;
    cv::line(canvas, {right, 0}, {right, size_px}, cv::Scalar(rng.Uniform(0.3, 0.6)), size_px / 50);
  }
  for (const int at : {size_px / 2, size_px / 3}) {
    const bool is_upright = at == size_px / 2;
    cv::line(canvas,
             is_upright ? cv::Point(at, 0) : cv::Point(0, at),
             is_upright ? cv::Point(at, size_px) : cv::Point(size_px, at),
             cv::Scalar(0.8),
             size_px / 36);
  }
  cv::rectangle(canvas, {0, 0, size_px, size_px}, cv::Scalar(0.85), size_px / 18);
  return canvas;
}

GreyCanvas Asphalt(int size_px, Rng& rng) {
  GreyCanvas canvas(0.3 + 0.05 * FractalNoise({size_px, 2, 1, 0.85}, rng));
  Speckle(canvas, size_px * 8, 5, 0.14, rng);
  const GreyCanvas cracks(cv::abs(FractalNoise({size_px, 2, 1, 0.8}, rng)));
  canvas.setTo(0.14, cracks < 0.008);
  cv::rectangle(
      canvas, {size_px / 5, size_px / 3, size_px / 8, size_px / 10}, cv::Scalar(0.24), cv::FILLED);
  Speckle(canvas, size_px * 4, 6, 0.16, rng);
  return canvas;
}

GreyCanvas Paving(int size_px, Rng& rng) {
  GreyCanvas canvas(0.5 + 0.03 * FractalNoise({size_px, 2, 1, 0.9}, rng));
  constexpr int kSlabs = 6;
  const int side = size_px / kSlabs;
  for (int i = 0; i < kSlabs * kSlabs; ++i) {
    cv::Mat1f slab = canvas(cv::Rect(i % kSlabs * side, i / kSlabs * side, side, side));
    slab += rng.Uniform(-0.07, 0.07);
    cv::rectangle(slab, {0, 0, side, side}, cv::Scalar(0.25), 5);
  }
  Speckle(canvas, size_px * 5, 4, 0.14, rng);
  return canvas;
}

std::vector<std::filesystem::path> ListImages(const std::filesystem::path& folder) {
  std::error_code error;
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    if (entry.is_regular_file()) files.push_back(entry.path());
  }
  if (error) throw InputError(folder.string() + ": textures: " + error.message());
  if (files.empty()) {
    throw InputError(folder.string() +
                     ": textures: holds no image; put PNG, JPEG or WebP files in");
  }
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

void MaterialLibrary::Add(
    Rng& rng, const std::string& name, double tile_m, double gloss, Painter painter) {
  materials_.push_back({name, {}, tile_m, gloss, 0});
  painters_.push_back(std::move(painter));
  seeds_.push_back(rng.Next());  // adding a material leaves those before it as they are
}

void MaterialLibrary::AddCommon(Rng& rng) {
  Add(rng, "plaster", 5, 0, [](Rng& r) { return Plaster(kLarge, 0.012, r); });
  Add(rng, "rough_plaster", 5, 0, [](Rng& r) { return Plaster(kLarge, 0.035, r); });
  Add(rng, "concrete", 5, 0, [](Rng& r) { return Concrete(kLarge, r); });
  Add(rng, "linoleum", 5, 0.12, [](Rng& r) { return Linoleum(kLarge, r); });
  Add(rng, "carpet", 2.5, 0, [](Rng& r) { return Carpet(kMedium, r); });
  Add(rng, "wood", 0.8, 0.08, [](Rng& r) { return Planks(kMedium, 6, r); });
  Add(rng, "boards", 1.2, 0.03, [](Rng& r) { return Planks(kMedium, 3, r); });
  Add(rng, "brick", 1.3, 0, [](Rng& r) { return Bricks(kMedium, r); });
  Add(rng, "fabric", 1.5, 0, [](Rng& r) { return Fabric(kMedium, r); });
  Add(rng, "cardboard", 0, 0, [](Rng& r) { return Cardboard(kMedium, r); });
  Add(rng, "metal", 1.5, 0.5, [](Rng& r) { return Metal(kMedium, r); });
  Add(rng, "stone", 1.5, 0, [](Rng& r) { return Stone(kMedium, 0.13, r); });
  Add(rng, "soil", 4, 0, [](Rng& r) { return Stone(kLarge, 0.1, r); });
  Add(rng, "leaf", 0, 0.05, [](Rng& r) { return Leaf(kSmall, r); });
  Add(rng, "tape", 0.3, 0.05, [](Rng&) { return WarningTape(kSmall); });
  Add(rng, "dark", 1, 0.2, [](Rng&) { return GreyCanvas(4, 4, 0.06F); });
  Add(rng, "lamp", 1, 0, [](Rng&) { return GreyCanvas(4, 4, 1.0F); });
  materials_.back().glow = 3;
}

void MaterialLibrary::AddPictures(Rng& rng, const std::filesystem::path& image_folder) {
  constexpr int kNumPhotos = 8, kNumPrints = 4;
  if (!image_folder.empty()) {
    for (const auto& file : ListImages(image_folder))
      AddPicture(file);
    return;
  }
  for (int i = 0; i < kNumPhotos + kNumPrints; ++i) {
    pictures_.push_back(static_cast<int>(materials_.size()));
    if (i < kNumPhotos) {
      Add(rng, "photo" + std::to_string(i), 0, 0.03, [](Rng& r) { return DeadLeaves(kMedium, r); });
    } else {
      Add(rng, "print" + std::to_string(i - kNumPhotos), 0, 0.03, [](Rng& r) {
        return PrintedSheet(kMedium, r);
      });
    }
  }
}

void MaterialLibrary::AddForOfficeAndYard(Rng& rng) {
  Add(rng, "whiteboard", 0, 0.05, [](Rng& r) { return Whiteboard(kMedium, r); });
  Add(rng, "screen", 0, 0.1, [](Rng& r) { return Screen(kSmall, r); });
  Add(rng, "machine", 0, 0.1, [](Rng& r) { return MachineCover(kMedium, 0.5, r); });
  Add(rng, "dark_machine", 0, 0.15, [](Rng& r) { return MachineCover(kMedium, 0.28, r); });
  Add(rng, "sheeting", 4, 0.1, [](Rng& r) { return Sheeting(kMedium, r); });
  Add(rng, "render", 9, 0, [](Rng& r) { return Render(kLarge, 0.05, r); });
  Add(rng, "smooth_render", 9, 0, [](Rng& r) { return Render(kLarge, 0.015, r); });
  Add(rng, "facing_brick", 2.6, 0, [](Rng& r) { return Bricks(kLarge, r); });
  Add(rng, "glass", 0, 0.2, [](Rng& r) { return Glass(kSmall, r); });
  Add(rng, "asphalt", 9, 0, [](Rng& r) { return Asphalt(kLarge, r); });
  Add(rng, "paving", 3.6, 0, [](Rng& r) { return Paving(kLarge, r); });
  Add(rng, "grass", 6, 0, [](Rng& r) { return Stone(kLarge, 0.08, r); });
}

MaterialLibrary::MaterialLibrary(std::uint64_t seed, const std::filesystem::path& image_folder) {
  Rng rng(seed);
  AddCommon(rng);
  AddPictures(rng, image_folder);
  AddForOfficeAndYard(rng);
}

void MaterialLibrary::Paint(const std::set<int>& used, int num_threads) {
  std::vector<std::size_t> due;
  for (const int index : used) {
    const auto i = static_cast<std::size_t>(index);
    if (materials_[i].texture.width() == 0) due.push_back(i);
  }
  ParallelFor(static_cast<int>(due.size()), num_threads, [&](int k) {
    const std::size_t i = due[static_cast<std::size_t>(k)];
    Rng rng(seeds_[i]);
    materials_[i].texture = Texture(painters_[i](rng));
  });
}

int MaterialLibrary::Find(const std::string& name) const {
  const auto at = std::find_if(
      materials_.begin(), materials_.end(), [&](const Material& m) { return m.name == name; });
  return at == materials_.end() ? -1 : static_cast<int>(at - materials_.begin());
}

int MaterialLibrary::Get(const std::string& name) const {
  const int index = Find(name);
  FACET_CHECK(index >= 0) << "no material '" << name << "'";
  return index;
}

int MaterialLibrary::AddPicture(const std::filesystem::path& file) {
  cv::Mat image;
  ImageReader().Read(file, image);
  GreyCanvas canvas;
  image.convertTo(canvas, CV_32F, 1.0 / 255);
  pictures_.push_back(static_cast<int>(materials_.size()));
  materials_.push_back({file.string(), Texture(canvas), 0, 0.03, 0});
  painters_.emplace_back();
  seeds_.push_back(0);
  return pictures_.back();
}

int MaterialLibrary::RandomPicture(Rng& rng) const {
  return pictures_[static_cast<std::size_t>(rng.Index(static_cast<int>(pictures_.size())))];
}

std::string MaterialLibrary::Names() const {
  std::string names;
  for (const Material& m : materials_)
    names += (names.empty() ? "" : ", ") + m.name;
  return names;
}

}  // namespace facet
