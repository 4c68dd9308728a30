// test_eds.cpp: the EDS reader: the three personalities' files, and files with something wrong.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "bench.hpp"
#include "eds.hpp"
#include "personality.hpp"

namespace gonio::sim {
namespace {

const std::filesystem::path eds_directory = GONIO_SOURCE_DIR "/protocol/eds";

std::string refusal(const std::string &from, const std::string &to) {
    std::ifstream original(eds_directory / "gonio_full.eds");
    std::string text((std::istreambuf_iterator<char>(original)), std::istreambuf_iterator<char>());
    const auto place = text.find(from);
    EXPECT_NE(place, std::string::npos) << from;
    text.replace(place, from.size(), to);
    const auto path = std::filesystem::temp_directory_path() /
                      ("gonio_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()) + ".eds");
    std::ofstream(path) << text;
    std::string what;
    try {
        const Object_dictionary dictionary(read_eds(path), 1);
    } catch (const std::runtime_error &error) {
        what = error.what();
    }
    std::filesystem::remove(path);
    return what;
}

TEST(Eds, numbers_are_decimal_hexadecimal_or_relative_to_the_node) {
    EXPECT_EQ(eds_number("0x1F", 5), 31);
    EXPECT_EQ(eds_number("-3", 5), -3);
    EXPECT_EQ(eds_number("$NODEID+0x40000180", 5), 0x40000185);
    EXPECT_EQ(eds_number("0x80 + $NodeID", 5), 0x85);
    EXPECT_EQ(eds_number("$NODEID", 5), 5);
    EXPECT_FALSE(eds_number("12 counts", 5));
    EXPECT_FALSE(eds_number("", 5));
}

TEST(Eds, entries_have_the_types_rights_and_limits_of_the_file) {
    Object_dictionary dictionary(read_eds(eds_directory / "gonio_full.eds"), 3);
    EXPECT_EQ(dictionary.at(0x1000).value, 0x00040192); // stepper drive, CiA 402
    EXPECT_EQ(dictionary.at(0x1400, 1).value, 0x203);
    EXPECT_EQ(dictionary.at(0x1801, 1).value, 0xC0000283);
    EXPECT_EQ(dictionary.at(0x607D, 1).value, -2147483648LL);
    EXPECT_TRUE(dictionary.at(0x607A).mappable);
    EXPECT_TRUE(dictionary.at(0x607A).is_signed);
    EXPECT_FALSE(dictionary.at(0x6041).writable);
    EXPECT_EQ(dictionary.at(0x1019).high, 240);
    EXPECT_EQ(dictionary.at(0x60C2, 2).value, -3);
    EXPECT_EQ(dictionary.find(0x607D, 3), nullptr);
    EXPECT_TRUE(dictionary.has_index(0x607D));
    EXPECT_FALSE(dictionary.has_index(0x6079));
    EXPECT_THROW((void)dictionary.at(0x6079), std::runtime_error);

    dictionary.at(0x6083).value = 1;
    dictionary.at(0x1017).value = 1;
    dictionary.reset(0x1000, 0x1FFF);
    EXPECT_EQ(dictionary.at(0x1017).value, 0);
    EXPECT_EQ(dictionary.at(0x6083).value, 1);
}

TEST(Eds, personalities_differ_where_they_say) {
    Object_dictionary full(load_personality("full", eds_directory), 1);
    Object_dictionary basic(load_personality("basic", eds_directory), 1);
    Object_dictionary fixed(load_personality("fixed", eds_directory), 1);
    EXPECT_NE(full.find(0x6007), nullptr);
    EXPECT_EQ(basic.find(0x6007), nullptr);
    EXPECT_FALSE(basic.has_index(0x1029));
    EXPECT_TRUE(full.at(0x60C2, 1).writable);
    EXPECT_FALSE(basic.at(0x60C2, 1).writable);
    EXPECT_EQ(basic.at(0x60C2, 1).value, 2);
    EXPECT_EQ(fixed.at(0x6065).value, 0xFFFFFFFF);
    EXPECT_FALSE(fixed.at(0x1600, 0).writable);
    EXPECT_EQ(fixed.at(0x1600, 2).value, 0x607A0020);
    EXPECT_EQ(fixed.at(0x1A00, 0).value, 3);
    try {
        load_personality("fancy", eds_directory);
        FAIL() << "an unknown personality was taken";
    } catch (const std::runtime_error &error) {
        EXPECT_NE(std::string(error.what()).find("full, basic or fixed"), std::string::npos);
    }
}

TEST(Eds, objects_are_named_by_index_and_sub_index) {
    const auto deadline = object_name("0x1400:05");
    ASSERT_TRUE(deadline && deadline->subindex);
    EXPECT_EQ(deadline->index, 0x1400);
    EXPECT_EQ(*deadline->subindex, 5);
    EXPECT_EQ(object_text(*deadline), "0x1400:05");
    const auto whole = object_name("0x60fe");
    ASSERT_TRUE(whole && !whole->subindex);
    EXPECT_EQ(object_text(*whole), "0x60FE");
    for (const char *const text : {"", "0x", "6007", "0x600", "0x6007:", "0x6007:1", "0x6007:001", "0x6007:-1",
                                   "0x60G7", "0x6007.01", "0x-607", "0x6007:0x", "0x1400:05 "}) {
        EXPECT_FALSE(object_name(text)) << text;
    }
}

TEST(Eds, a_missing_file_is_named) {
    try {
        read_eds(eds_directory / "nothing.eds");
        FAIL() << "a missing file was read";
    } catch (const std::runtime_error &error) {
        EXPECT_NE(std::string(error.what()).find("nothing.eds"), std::string::npos);
    }
}

TEST(Eds, a_listed_object_without_a_section_is_named) {
    EXPECT_NE(refusal("[6040]", "[6FFF]").find("[6040]"), std::string::npos);
}
TEST(Eds, an_object_that_no_list_names_is_an_error) {
    EXPECT_NE(refusal("[MandatoryObjects]", "[5FFF]\nParameterName=x\n\n[MandatoryObjects]").find("5fff"),
              std::string::npos);
}
TEST(Eds, a_wrong_count_of_sub_objects_is_an_error) {
    EXPECT_NE(refusal("[1018]\nParameterName=Identity object\nObjectType=0x9\nSubNumber=5",
                      "[1018]\nParameterName=Identity object\nObjectType=0x9\nSubNumber=4")
                  .find("SubNumber"),
              std::string::npos);
}
TEST(Eds, a_default_beyond_the_type_is_an_error) {
    EXPECT_NE(refusal("DefaultValue=0x00040192", "DefaultValue=0x100040192").find("default value"), std::string::npos);
}
TEST(Eds, text_that_is_neither_section_nor_key_is_an_error) {
    EXPECT_NE(refusal("[FileInfo]", "[FileInfo]\nrubbish").find("neither"), std::string::npos);
}

} // namespace
} // namespace gonio::sim
