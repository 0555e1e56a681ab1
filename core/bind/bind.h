// What the files of this folder share: one function a folder of core/, and the way from vectors to arrays.
#pragma once

#include <cstddef>
#include <initializer_list>
#include <type_traits>
#include <utility>
#include <vector>

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

namespace trimray::bind {

namespace nb = nanobind;

void bind_store(nb::module_& m);
// Every array of a Store, by name, sharing its memory (bind_store_arrays.cpp).
nb::dict store_arrays(nb::handle store);
void bind_trace(nb::module_& m);
void bind_seeds(nb::module_& m);
void bind_view(nb::module_& m);
void bind_measure(nb::module_& m);
void bind_bench(nb::module_& m);
void bind_mesh_file(nb::module_& m);
void bind_mesh_check(nb::module_& m);
void bind_mesh_measure(nb::module_& m);
void bind_tess(nb::module_& m);
void bind_mesh_levels(nb::module_& m);
void bind_raster(nb::module_& m);
void bind_distance(nb::module_& m);
void bind_mass(nb::module_& m);

template <typename T>
using In1 = nb::ndarray<const T, nb::shape<-1>, nb::c_contig, nb::device::cpu>;
template <typename T, int Columns>
using In2 = nb::ndarray<const T, nb::shape<-1, Columns>, nb::c_contig, nb::device::cpu>;
template <typename T>
using Out = nb::ndarray<nb::numpy, T>;

// A NumPy array that takes the vector over, without a copy. values.size() is the product of the shape.
template <typename T>
Out<T> array(std::vector<T>&& values, std::initializer_list<std::size_t> shape) {
  auto* kept = new std::vector<T>(std::move(values));
  nb::capsule owner(kept, [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); });
  return Out<T>(kept->data(), shape, owner);
}

template <typename Array>
auto vector(const Array& a) {
  return std::vector<std::remove_const_t<typename Array::Scalar>>(a.data(), a.data() + a.size());
}

}  // namespace trimray::bind
