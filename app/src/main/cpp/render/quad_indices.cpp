#include "render/quad_indices.h"

#include "gl/vertex_array.h"

namespace fluxgs::render {

Expected<gl::Buffer> create_quad_indices(gl::Api& api, int quads) {
  std::vector<std::uint16_t> indices;
  for (int q = 0; q < quads; ++q)
    for (const int corner : {0, 1, 2, 2, 1, 3})
      indices.push_back(static_cast<std::uint16_t>(4 * q + corner));
  const gl::VertexArray theirs(api);  // who draws binds them to another
  theirs.bind();
  auto made = gl::Buffer::create(api, indices.size() * sizeof(indices[0]), indices.data(),
                                 GL_STATIC_DRAW, GL_ELEMENT_ARRAY_BUFFER);
  api.BindVertexArray(0);
  return made;
}

}  // namespace fluxgs::render
