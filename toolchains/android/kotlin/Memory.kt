// Memory that C sees, and what keeps it there: what the generated classes stand on.
//
// A buffer of Java is kept while an object that points into it is: a buffer keeps what its pointers name, and a call keeps its
// arguments. What was closed throws, also where a struct still names it.
package org.sandglass

import java.io.Closeable
import java.nio.ByteBuffer
import java.nio.ByteOrder

/** The library refused; the message is its sentence: what is wrong, where, and what to do. */
class SandglassException(val status: Int, sentence: String?) : RuntimeException(sentence)

/** What a pointer leads to: a buffer, a struct, a handle. */
abstract class Memory { abstract val address: Long }

/** Bytes for C to read or write, the whole of a direct buffer, and what pointers among them lead to. */
class Buffer(val bytes: ByteBuffer) : Memory() {
  constructor(size: Int) : this(ByteBuffer.allocateDirect(size).order(ByteOrder.nativeOrder()))
  init { require(bytes.isDirect && bytes.order() == ByteOrder.nativeOrder()) { "the buffer is not direct, or not in native order" } }
  private val start = Native.address(bytes)
  private val places = ArrayList<Int>()
  private val named = ArrayList<Memory?>()
  override val address: Long
    get() {
      for (i in places.indices) bytes.putLong(places[i], address(named[i]))  // what was closed throws
      return start
    }
  internal fun kept(at: Int) = named.getOrNull(places.indexOf(at))
  /** Writes a pointer, for as long as the buffer is there. */
  fun keep(at: Int, of: Memory?) {
    bytes.putLong(at, address(of))
    val i = places.indexOf(at)
    if (i < 0) { places.add(at); named.add(of) } else named[i] = of
  }
}

/** An array of pointers. */
fun pointers(vararg of: Memory) = Buffer(8 * of.size).also { of.forEachIndexed { i, one -> it.keep(8 * i, one) } }

/** A struct at a place of a buffer. */
abstract class Struct(val span: Buffer, val at: Int) : Memory() { override val address get() = span.address + at }

/** A fixed array of floats, in a struct or by itself. */
class Floats(private val span: Buffer, private val at: Int, val count: Int) : Memory() {
  constructor(vararg of: Float) : this(Buffer(4 * of.size), 0, of.size) { set(*of) }
  override val address get() = span.address + at
  operator fun get(i: Int) = span.bytes.getFloat(element(at, i, count, 4))
  operator fun set(i: Int, to: Float) { span.bytes.putFloat(element(at, i, count, 4), to) }
  fun set(vararg to: Float) = to.forEachIndexed { i, one -> this[i] = one }
}

/** A handle and the block that it lives in. One belongs to one thread at a time. */
abstract class Owned internal constructor(private val kind: String, desc: Memory, need: (Memory) -> Unit, create: (Memory, Long, Memory) -> Unit) : Memory(), Closeable {
  private val kept = hashMapOf<String, Memory?>("desc" to desc)
  private var block: Buffer?
  private var handle: Long

  init {
    val answer = Buffer(8).also(need)
    val bytes = answer.bytes.getLong(0)
    if (bytes > Int.MAX_VALUE - SANDGLASS_BLOCK_ALIGNMENT)
      throw SandglassException(SANDGLASS_ERROR_MEMORY_TOO_SMALL, "$kind: a block of $bytes bytes is larger than a buffer can be: lower the capacities.")
    val whole = Buffer(bytes.toInt() + SANDGLASS_BLOCK_ALIGNMENT)
    block = Buffer(part(whole.bytes, (-whole.address).toInt() and SANDGLASS_BLOCK_ALIGNMENT - 1, bytes.toInt()))
    create(block!!, bytes, answer)
    handle = answer.bytes.getLong(0)
  }

  override val address get() = if (handle != 0L) handle else throw IllegalStateException("this $kind is closed")
  /** What the library told the address of, such as the chunks of a mesh: bytes of this block, valid until the next call. */
  fun memory(from: Long, size: Int): ByteBuffer {
    address(this)
    val begin = if (size == 0) 0L else from - block!!.address
    require(size >= 0 && begin >= 0 && begin + size <= block!!.bytes.capacity()) { "these bytes are not of this $kind" }
    return part(block!!.bytes, begin.toInt(), size)
  }
  internal fun keep(by: String, of: Memory?) { kept[by] = of }
  protected open fun release() {}
  override fun close() {
    if (handle != 0L) release()
    handle = 0L
    block = null
  }
}

// Position and limit of ByteBuffer itself are newer than Android 24.
private fun part(of: ByteBuffer, begin: Int, size: Int): ByteBuffer {
  val all = of.duplicate()
  (all as java.nio.Buffer).limit(begin + size).position(begin)
  return all.slice().order(ByteOrder.nativeOrder())
}
internal fun address(memory: Memory?) = memory?.address ?: 0L
internal fun address(floats: Floats?, count: Int): Long {
  require(floats == null || floats.count == count) { "${floats!!.count} floats where $count are taken" }
  return address(floats)
}
internal fun element(at: Int, i: Int, count: Int, size: Int) = if (i in 0 until count) at + i * size else throw IndexOutOfBoundsException("$i is not below $count")
