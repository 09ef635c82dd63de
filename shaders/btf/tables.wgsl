// The tables of one material or of many. Who imports this says where they are bound, by the shader
// definitions BTF_GROUP and BTF_TABLES.

#define_import_path farlight::btf::tables

@group(#{BTF_GROUP}) @binding(#{BTF_TABLES}) var<storage, read> btf_words: array<u32>;
