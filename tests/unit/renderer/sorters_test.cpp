// Every sorter against the exact one: the order of the splats that the image shows.
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include <glm/geometric.hpp>

#include "gl_fixture.h"
#include "scenes.h"
#include "sort/sort_thread.h"

namespace fluxgs::test {
namespace {

using render::SorterKind;
using Order = std::vector<std::uint32_t>;

constexpr SorterKind kKinds[] = {SorterKind::gpu_radix, SorterKind::cpu_async, SorterKind::exact};

std::string name(SorterKind kind) {
  return kind == SorterKind::gpu_radix ? "GPU" : kind == SorterKind::cpu_async ? "CPU" : "exact";
}

class SortersTest : public GlTest {
 protected:
  // Draws the cloud; returns the order without splats that the image does not show.
  Order shown_order(SorterKind kind, const SplatCloud& cloud, const Camera& camera, int key_bits) {
    const auto made = must(
        render::Renderer::create(api(), {.sorter = kind, .approximation = {.key_bits = key_bits}}));
    must(made->upload(cloud));
    const auto target = must(render::RenderTarget::create(api(), camera.width, camera.height,
                                                          render::TargetFormat::rgba16f));
    must(made->draw(camera, {}, target));
    image_ = must(made->read(target)).pixels;
    if (cloud.size() == 0) return {};
    const auto count = must(made->sorter().count().read_all<std::uint32_t>(1)).front();
    Order order = must(made->sorter().order().read_all<std::uint32_t>(count));
    const auto keys = must(made->projection().keys().read_all<std::uint32_t>(cloud.size()));
    std::erase_if(order, [&](std::uint32_t i) { return keys[i] == sort::kDropped; });
    return order;
  }

  // All sorters list the same splats; depths never increase by more than `slack`, relatively.
  void expect_parity(const std::string& label, const SplatCloud& cloud, const Camera& camera,
                     int key_bits = 32, double slack = 1e-6) {
    const Order expected = shown_order(SorterKind::exact, cloud, camera, 32);
    const auto depth = [&](std::uint32_t i) {
      return glm::dot(camera.forward(), glm::dvec3(cloud.positions[i]) - camera.center());
    };
    for (const SorterKind kind : kKinds) {
      const std::string where = label + ", " + name(kind);
      Order order = shown_order(kind, cloud, camera, key_bits);
      for (std::size_t i = 1; i < order.size(); ++i)
        ASSERT_GE(depth(order[i - 1]), depth(order[i]) * (1 - slack)) << where << " at " << i;
      Order listed = order, wanted = expected;
      std::ranges::sort(listed);
      std::ranges::sort(wanted);
      EXPECT_EQ(listed, wanted) << where;
    }
  }

  std::pmr::vector<float> image_;
};

TEST_P(SortersTest, RandomClouds) {
  const SplatCloud cloud = random_cloud(5000, 0, 1);
  expect_parity("outside", cloud, orbit_camera(160, 120, {}, 2.5, 1, 4));
  expect_parity("inside", cloud, orbit_camera(160, 120, {}, 0.3, 1, 4));
  expect_parity("16 bits", cloud, orbit_camera(160, 120, {}, 2.5, 2, 4), 16, 1e-3);
  expect_parity("24 bits", cloud, orbit_camera(160, 120, {}, 0.3, 2, 4), 24, 1e-5);
}

// Equal depths: the smaller index lies in front, so it is drawn last.
TEST_P(SortersTest, TiesGoByIndex) {
  SplatCloud cloud = random_cloud(3000, 0, 2);
  for (glm::vec3& p : cloud.positions) p = {0.3F * p.x, 0.3F * p.y, 0.125F};
  const Camera camera = front_camera(160, 120, 1);
  for (std::size_t i = 0; i < cloud.size(); ++i) cloud.opacity_logits[i] = 1;
  for (const SorterKind kind : kKinds) {
    const Order order = shown_order(kind, cloud, camera, 24);
    EXPECT_EQ(order.size(), cloud.size());
    EXPECT_TRUE(std::ranges::is_sorted(order, std::greater{})) << name(kind);
  }
}

TEST_P(SortersTest, CountsAroundWorkGroups) {
  for (const std::size_t count : {1, 2, 127, 128, 129, 2047, 2048, 2049, 4097})
    expect_parity(std::to_string(count), random_cloud(count, 0, 3),
                  orbit_camera(64, 48, {}, 2.5, 1, 4));
}

TEST_P(SortersTest, NothingToSort) {
  for (const SorterKind kind : kKinds) {
    EXPECT_TRUE(shown_order(kind, {}, front_camera(8, 8, 2), 24).empty());
    SplatCloud behind = random_cloud(300, 0, 4, {0, 0, -50});
    EXPECT_TRUE(shown_order(kind, behind, front_camera(8, 8, 2), 24).empty()) << name(kind);
    EXPECT_TRUE(std::ranges::all_of(image_, [](float v) { return v == 0; })) << name(kind);
    SplatCloud broken = random_cloud(300, 0, 4);
    for (glm::vec3& p : broken.positions) p.x = std::nanf("");
    EXPECT_TRUE(shown_order(kind, broken, front_camera(8, 8, 2), 24).empty()) << name(kind);
  }
}

TEST_P(SortersTest, TheSameImageFromEach) {
  const SplatCloud cloud = random_cloud(4000, 1, 5);
  const Camera camera = orbit_camera(160, 120, {}, 2, 1, 4);
  static_cast<void>(shown_order(SorterKind::exact, cloud, camera, 32));
  const auto expected = image_;
  for (const SorterKind kind : {SorterKind::gpu_radix, SorterKind::cpu_async}) {
    static_cast<void>(shown_order(kind, cloud, camera, 32));
    EXPECT_EQ(image_, expected) << name(kind);
  }
}

// Frames between are drawn with an order of some view before, and the last one is right again.
TEST_P(SortersTest, OrdersOfAMovingCameraCatchUp) {
  const SplatCloud cloud = random_cloud(3000, 0, 6);
  const auto late = must(render::Renderer::create(api(), {.sorter = SorterKind::cpu_async}));
  must(late->upload(cloud));
  const auto target =
      must(render::RenderTarget::create(api(), 80, 60, render::TargetFormat::rgba16f));
  Camera camera;
  for (int i = 0; i < 30; ++i) {
    camera = orbit_camera(80, 60, {}, 2, i, 60);
    must(late->draw(camera, {}, target));
  }
  late->wait_for_sorts(true);
  must(late->draw(camera, {}, target));
  const auto image = must(late->read(target)).pixels;
  static_cast<void>(shown_order(SorterKind::exact, cloud, camera, 24));
  EXPECT_EQ(image, image_);
}

// So that a viewer can come to rest, however long its scene takes to be sorted.
TEST_P(SortersTest, AStillViewIsNotSortedAgain) {
  const auto late = must(render::Renderer::create(api(), {.sorter = SorterKind::cpu_async}));
  must(late->upload(random_cloud(200'000, 0, 6)));
  const auto target =
      must(render::RenderTarget::create(api(), 8, 6, render::TargetFormat::rgba16f));
  const Camera camera = orbit_camera(8, 6, {}, 2, 1, 60);
  late->wait_for_sorts(true);
  must(late->draw(camera, {}, target));
  EXPECT_GT(late->sort_latency(), 0);
  late->wait_for_sorts(false);
  for (int i = 0; i < 5; ++i) {
    must(late->draw(camera, {}, target));
    EXPECT_TRUE(late->order_is_current());
  }
}

/// Sorts when it is told to, and cannot wait: as in a browser.
class LateSort final : public sort::BackgroundSort {
 public:
  explicit LateSort(std::vector<glm::vec3> positions) : sort_(std::move(positions)) {}
  std::uint64_t request(const sort::SortView& view) override {
    view_ = view;
    return ++ticket_;
  }
  sort::SharedIndices newest() override { return newest_; }
  sort::SharedIndices wait(std::uint64_t) override { return newest_; }
  void finish() {
    auto made = std::make_shared<sort::IndexBuffer>();
    made->indices.resize(sort_.size());
    made->count = sort_.sort(view_, made->indices);
    made->ticket = ticket_;
    newest_ = made;
  }

 private:
  sort::DepthSort sort_;
  sort::SortView view_;
  std::uint64_t ticket_ = 0;
  sort::SharedIndices newest_;
};

// Nothing is drawn until the first order comes, and the image is asked for again until it does.
TEST_P(SortersTest, OrdersThatCannotBeWaitedFor) {
  LateSort* late = nullptr;
  render::RendererSettings settings{.sorter = SorterKind::cpu_async};
  settings.background_sort = [&](std::vector<glm::vec3> positions) {
    auto made = std::make_unique<LateSort>(std::move(positions));
    late = made.get();
    return made;
  };
  const auto renderer = must(render::Renderer::create(api(), settings));
  const SplatCloud cloud = random_cloud(500, 0, 6);
  must(renderer->upload(cloud));
  const auto target =
      must(render::RenderTarget::create(api(), 40, 30, render::TargetFormat::rgba16f));
  const Camera camera = orbit_camera(40, 30, {}, 2, 1, 60);
  RenderOptions options;
  options.background = {0, 0.5, 0};
  for (int i = 0; i < 2; ++i) {
    must(renderer->draw(camera, options, target));
    EXPECT_FALSE(renderer->order_is_current());
    const Image<float> empty = must(renderer->read(target));
    for (std::size_t p = 0; p < empty.pixels.size(); p += 4) ASSERT_EQ(empty.pixels[p + 1], 0.5F);
  }
  late->finish();
  must(renderer->draw(camera, {}, target));
  EXPECT_TRUE(renderer->order_is_current());
  const auto image = must(renderer->read(target)).pixels;
  static_cast<void>(shown_order(SorterKind::exact, cloud, camera, 24));
  EXPECT_EQ(image, image_);
}

FLUXGS_GL_TEST_SUITE(SortersTest);

sort::SortView view_along_z() {
  return {.centre = {0, 0, 0},
          .forward = {0, 0, 1},
          .near_plane = 0.01,
          .keys = sort::depth_keys(0.01F, 1000.0F, 24)};
}

// A buffer that somebody holds is not written, however many sorts follow.
TEST(SortThread, HeldOrdersStay) {
  std::vector<glm::vec3> positions;
  for (int i = 0; i < 100; ++i) positions.emplace_back(0, 0, 1 + i);
  sort::SortThread thread(positions);
  const sort::SharedIndices held = thread.wait(thread.request(view_along_z()));
  const std::vector<std::uint32_t> before = held->indices;
  EXPECT_EQ(before.front(), 99U);
  sort::SortView other = view_along_z();
  other.centre.z = 200;
  other.forward.z = -1;
  for (int i = 0; i < 20; ++i) {
    const sort::SharedIndices next = thread.wait(thread.request(other));
    EXPECT_EQ(next->indices.front(), 0U);
    EXPECT_NE(next, held);
  }
  EXPECT_EQ(held->indices, before);
}

TEST(SortThread, OnlyTheNewestViewCounts) {
  sort::SortThread thread(std::vector<glm::vec3>(20'000, {0, 0, 1}));
  std::uint64_t ticket = 0;
  for (int i = 0; i < 1000; ++i) ticket = thread.request(view_along_z());
  EXPECT_EQ(thread.wait(ticket)->ticket, ticket);
  EXPECT_EQ(thread.newest()->ticket, ticket);
}

// Behind the camera but near enough to come into view: in front of all others. Far behind: left
// out.
TEST(SortThread, SplatsBehindTheCamera) {
  sort::SortThread thread({{0, 0, 5}, {1, 0, -0.1F}, {0, 0, -1}, {0, 0, 2}});
  const sort::SharedIndices order = thread.wait(thread.request(view_along_z()));
  ASSERT_EQ(order->count, 3U);
  EXPECT_EQ(order->indices[0], 0U);
  EXPECT_EQ(order->indices[1], 3U);
  EXPECT_EQ(order->indices[2], 1U);
}

TEST(DepthKeys, AreMonotoneAndFillTheirBits) {
  for (const int bits : {10, 16, 20, 24, 32}) {
    const sort::DepthKeys keys = sort::depth_keys(0.5F, 8.0F, bits);
    EXPECT_LE(keys.bits, bits);
    EXPECT_EQ(sort::depth_key(keys, 0.5F), 0U);
    EXPECT_EQ(sort::depth_key(keys, 8.0F), keys.largest);
    EXPECT_EQ(sort::depth_key(keys, 0.1F), 0U);
    EXPECT_EQ(sort::depth_key(keys, 1e9F), keys.largest);
    EXPECT_GE(keys.largest, (std::uint64_t{1} << std::min(bits, 25)) / 2 - 1);
    std::uint32_t before = 0;
    for (float depth = 0.5F; depth < 8; depth *= 1.001F) {
      const std::uint32_t key = sort::depth_key(keys, depth);
      EXPECT_GE(key, before);
      before = key;
    }
  }
  const sort::DepthKeys point = sort::depth_keys(2.0F, 2.0F, 24);
  EXPECT_EQ(point.largest, 0U);
  EXPECT_EQ(point.bits, 1);
}

}  // namespace
}  // namespace fluxgs::test
